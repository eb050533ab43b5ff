// SPDX-License-Identifier: Apache-2.0
// Tabulated isotropic reflectance in the layout of the MERL database (Matusik et al., "A
// Data-Driven Reflectance Model", SIGGRAPH 2003): 90 x 90 x 180 cells of 3 channels.

#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "brdf/brdf.h"
#include "brdf/direction.h"

namespace gonio {

// What Brdf::Eval is, as a plain function: empty where nothing is known.
using BrdfFunction = std::function<std::optional<Rgb>(const HalfDiff&)>;

// A `.binary` table, opened from a file or filled from a function. A cheap handle: copies share
// the cells, which never change.
//
// A file is int32 90, 90, 180, then float64 [channel][theta_h][theta_d][phi_d], little-endian;
// f_r = stored * (1, 1.15, 1.66) / 1500. theta_h cell i covers (i/90)^2 * 90 .. ((i+1)/90)^2 * 90
// deg: fine at the highlight. theta_d and phi_d cells are 1 deg wide; phi_d spans 180 deg.
//
// A cell is invalid if any of its channels is negative (the database's own mark), infinite or NaN.
// About a quarter of a table is invalid because one direction lies below the horizon.
class MerlTable final : public Brdf {
 public:
  static constexpr int kThetaH = 90;
  static constexpr int kThetaD = 90;
  static constexpr int kPhiD = 180;
  static constexpr int kCells = kThetaH * kThetaD * kPhiD;
  static constexpr std::size_t kHeaderBytes = 12;
  static constexpr std::size_t kFileBytes = kHeaderBytes + sizeof(double) * kChannels * kCells;

  // Maps the file, read-only; cells are read from disk as they are asked for, so this takes well
  // under a millisecond. The file must not shrink while the table is in use (replacing it by rename
  // is safe). Throws ConfigError "FILE: what is wrong" on an unreadable or truncated file, a wrong
  // size, wrong dimensions, or when every cell is invalid.
  static MerlTable Open(const std::filesystem::path& path);

  // Asks `f_r` at the centre of every cell above the horizon; the other cells, and those where it
  // has no value or one that is negative or not finite, become invalid. Takes 1.1 million calls.
  static MerlTable FromFunction(std::string name, const BrdfFunction& f_r);

  // Whole or not at all; throws std::runtime_error. A table that was opened is written back byte
  // for byte.
  void Write(const std::filesystem::path& path) const;

  // The angles at the middle of a cell, the middle of theta_h being that of sqrt(theta_h): cell h
  // is at ((h + 0.5) / 90)^2 * 90 deg. Preconditions here and below: 0 <= h < kThetaH, 0 <= d <
  // kThetaD, 0 <= p < kPhiD.
  static HalfDiff CellCentre(int h, int d, int p);
  // Width of a theta_h cell [rad]: the weight that makes a mean over cells uniform in angle.
  static double ThetaHWidth(int h);

  // f_r of one cell [1/sr]; empty if it is invalid.
  std::optional<Rgb> Cell(int h, int d, int p) const;

  // Linear in (sqrt theta_h, theta_d, phi_d) between cell centres, exactly the cell at its centre,
  // and constant beyond the outermost centres of theta_h and theta_d; phi_d wraps at pi
  // (reciprocity). Empty below the horizon and where the cell that holds the angles is invalid;
  // otherwise invalid neighbours are left out and the other weights scaled up.
  std::optional<Rgb> Eval(const HalfDiff& angles) const override;
  using Brdf::Eval;

  // The file's name without folder and extension, or what FromFunction() was given.
  std::string name() const override { return name_; }

 private:
  MerlTable(std::string name, std::shared_ptr<const void> storage, const std::byte* file);

  std::string name_;
  std::shared_ptr<const void> storage_;  // the mapping or the memory that `file_` points into
  const std::byte* file_;                // the kFileBytes of the file, header included
};

}  // namespace gonio
