// SPDX-License-Identifier: Apache-2.0
#include "fitting/process_material.h"

#include <algorithm>
#include <utility>

#include "fitting/generalised_log.h"

namespace gonio {

ProcessMaterial::ProcessMaterial(std::shared_ptr<const ProcessModel> model,
                                 const std::array<Eigen::VectorXd, kChannels>& weights,
                                 std::string name)
    : model_(std::move(model)), field_(model_->FieldOf(weights)), name_(std::move(name)) {}

std::optional<Rgb> ProcessMaterial::Eval(const HalfDiff& angles) const {
  double cos_i = 0;
  double cos_o = 0;
  Cosines(angles, &cos_i, &cos_o);
  if (!(cos_i > 0 && cos_o > 0)) return std::nullopt;
  const Eigen::Vector3d z = model_->transform().transpose() * model_->SeriesAt(angles, field_);
  Rgb f_r;
  for (int c = 0; c < kChannels; ++c) {
    f_r[c] = std::max(FromGeneralisedLog(z[c], model_->floor()), 0.0);
  }
  return f_r;
}

}  // namespace gonio
