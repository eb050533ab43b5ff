// SPDX-License-Identifier: Apache-2.0
// What is believed about a material before it is measured.

#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "fitting/dsbrdf.h"
#include "fitting/process_prior.h"

namespace gonio {

// A Gaussian over the parameter vector of a Dsbrdf (Lombardi & Nishino, "Reflectance and
// Illumination Recovery in the Wild", 2012, learn one from MERL).
struct Prior {
  std::string name;
  DsbrdfShape shape;
  Eigen::VectorXd mean;        // shape.size()
  Eigen::MatrixXd covariance;  // symmetric, positive definite
  // Names of the materials it was learned from; empty for the generic one. A study refuses to score
  // a material against a prior that lists it.
  std::vector<std::string> materials;
  // What the materials' whole reflectance was learned to do; null where nothing was learned.
  std::shared_ptr<const ProcessPrior> process;
};

// Whether the prior was learned from a material of this name: judged on that it looks too good.
bool HasSeen(const Prior& prior, const std::string& material);

// The built-in prior: no material was used to make it; its assumptions stand in docs/fitting.md.
Prior GenericPrior(const DsbrdfShape& shape = {});

// As little as a fit can do with: the generic prior's means, its spreads kUnbelief times as wide.
// It keeps lobes of which the samples say nothing from running away, and little else. "none".
inline constexpr double kUnbelief = 5;
Prior NoPrior(const DsbrdfShape& shape = {});

// A prior file (docs/data-format.md). Throws ConfigError: wrong version, sizes, a covariance that
// is not symmetric and positive definite.
Prior ReadPrior(const std::filesystem::path& path);
void WritePrior(const std::filesystem::path& path, const Prior& prior);

}  // namespace gonio
