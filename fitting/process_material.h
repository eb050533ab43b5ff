// SPDX-License-Identifier: Apache-2.0
// A material of a process's own making: to try plans on before there is any other.

#pragma once

#include <array>
#include <memory>
#include <string>

#include "brdf/brdf.h"
#include "fitting/process_model.h"

namespace gonio {

// The reflectance a process has where its weights are these. Standard normal weights give a
// material as the prior expects them, stationary part included.
class ProcessMaterial final : public Brdf {
 public:
  // weights[s]: of series s, as many as its group has features (ProcessModel::Group::size).
  ProcessMaterial(std::shared_ptr<const ProcessModel> model,
                  const std::array<Eigen::VectorXd, kChannels>& weights, std::string name);

  using Brdf::Eval;
  // Empty below the horizon; never negative.
  std::optional<Rgb> Eval(const HalfDiff& angles) const override;
  std::string name() const override { return name_; }

 private:
  std::shared_ptr<const ProcessModel> model_;
  Eigen::MatrixXd field_;
  std::string name_;
};

}  // namespace gonio
