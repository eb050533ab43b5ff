// SPDX-License-Identifier: Apache-2.0
// Directions others have published or computed from a database, as lists for a SequencePlanner.
//
// Each returns indices into the candidates, all different, in the order in which they are measured.
// Candidates with a direction more than kListMaxPolar from the normal are not taken, unless there
// are no others: there the tables that databases consist of are extrapolated.

#pragma once

#include <vector>

#include "core/units.h"
#include "fitting/pca_reflectance.h"
#include "planner/candidates.h"

namespace gonio {

inline constexpr double kListMaxPolar = RadFromDeg(80);

// The candidates nearest to the five directions of Nielsen, Jensen & Ramamoorthi ("On Optimal,
// Minimal BRDF Sampling for Reflectance Acquisition", ICCV 2015), which they found by descending on
// the condition number of the rows of the MERL basis. Where the raster leaves one candidate per
// (theta_h, theta_d), phi_d is only as near as that allows. No more than five: they publish no
// longer list of one order.
std::vector<int> NielsenOrder(const std::vector<Candidate>& candidates);

// Column-pivoted QR of [Q'; sqrt(d) I], a column for each candidate (rows of Q as in
// fitting/pca_reflectance.h; d a small variance of what no component explains, 0.02 per 96 training
// columns, a reading's error of 1.5 %): each next direction is the one that those before predict
// worst (P. Businger & G. Golub, 1965; Z. Drmac & S. Gugercin, 2016, use it to place sensors). The
// first n are the directions for n samples, so one order serves all budgets. The diagonal keeps it
// defined beyond the rank of the basis, where directions are repeated nearby to average over it.
std::vector<int> PivotedOrder(const std::vector<Candidate>& candidates, const PcaBasis& basis,
                              int count);

// In the manner of FROST (Miandji, Tongbuasirilai, Hajisharif, Kavoosighafi & Unger, "FROST-BRDF: A
// Fast and Robust Optimal Sampling Technique for BRDF Acquisition", 2024): choosing where to sample
// is solving for a Z with few nonzero rows, rows being directions,
//
//   S = U'Z,   U: basis, a row for each direction;   S: coefficients of the training columns
//
// (multiple measurement vectors) by simultaneous orthogonal matching pursuit: the next direction is
// the one whose row of U, normalised, takes most of the residual of S away, in the sum of squares
// over the training columns; then everything the chosen rows span is projected out.
//
// Written from the paper's abstract and formulation. Where it may differ: their dictionary can be a
// learned ensemble, ours is the first n principal components for n directions; their norm over the
// columns may be another. When the residual is used up (n beyond the rank) we start again with the
// directions that are left. The order depends on `count`.
std::vector<int> FrostOrder(const std::vector<Candidate>& candidates, const PcaBasis& basis,
                            int count);

}  // namespace gonio
