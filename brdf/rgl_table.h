// SPDX-License-Identifier: Apache-2.0
// Isotropic RGB reflectance measured by RGL, in their adaptive parameterisation (Dupuy & Jakob, "An
// Adaptive Parameterization for Efficient Material Acquisition and Rendering", ACM TOG 37(6),
// 2018).

#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "brdf/brdf.h"

namespace gonio {

// A `.bsdf` file ("tensor_file"). A cheap handle: copies share the data, which never change.
class RglTable final : public Brdf {
 public:
  // Throws ConfigError "FILE: what is wrong": not such a file, truncated, a field missing or of the
  // wrong type or shape, spectral or anisotropic (we read isotropic RGB).
  static RglTable Open(const std::filesystem::path& path);

  using Brdf::Eval;
  // The mean of both orders of the pair, as far as each is inside the domain: measured files are
  // reciprocal only up to noise. Empty where neither is.
  std::optional<Rgb> Eval(const HalfDiff& angles) const override;

  // f_r [1/sr], without the cosine, of this order of the pair. Empty below the horizon and outside
  // what was measured. May be slightly negative: colours out of gamut.
  std::optional<Rgb> EvalDirected(const DirectionPair& pair) const;

  // The file's name without folder and extension.
  std::string name() const override;
  // What the file says it is.
  const std::string& description() const;

 private:
  struct Data;
  explicit RglTable(std::shared_ptr<const Data> data) : data_(std::move(data)) {}
  std::shared_ptr<const Data> data_;
};

}  // namespace gonio
