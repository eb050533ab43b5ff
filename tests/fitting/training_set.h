// SPDX-License-Identifier: Apache-2.0
// A handful of materials of one family, to learn from in tests.

#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "fitting/training.h"
#include "tests/brdf/function_brdf.h"

namespace gonio {

// A diffuse base, in three shades, with a colourless peak whose height and width [rad] are given.
inline std::unique_ptr<Brdf> PeakedMaterial(double diffuse, double peak, double width) {
  return std::make_unique<FunctionBrdf>([=](const HalfDiff& a) -> std::optional<Rgb> {
    const double lobe = peak * std::exp(-std::pow(std::tan(a.theta_h) / width, 2));
    return Rgb(diffuse + lobe, 0.5 * diffuse + lobe, 0.2 * diffuse + lobe);
  });
}

// Eight of them, named "0" to "7".
class TrainingSet {
 public:
  TrainingSet() {
    for (int i = 0; i < 8; ++i) {
      owned_.push_back(
          PeakedMaterial(0.02 + 0.03 * i, std::exp(0.6 * (i * 5 % 8)), 0.15 + 0.05 * (i % 3)));
      materials_.push_back({std::to_string(i), owned_.back().get()});
    }
  }
  const std::vector<TrainingMaterial>& materials() const { return materials_; }

 private:
  std::vector<std::unique_ptr<Brdf>> owned_;
  std::vector<TrainingMaterial> materials_;
};

}  // namespace gonio
