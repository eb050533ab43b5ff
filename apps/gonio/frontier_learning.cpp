// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/frontier_learning.h"

namespace gonio {

Prior LearnFrom(std::span<const FrontierMaterial> materials, const std::string& name) {
  Prior prior = GenericPrior();  // until priors can be learned: it only remembers names
  prior.name = name;
  for (const FrontierMaterial& material : materials) prior.materials.push_back(material.name);
  return prior;
}

}  // namespace gonio
