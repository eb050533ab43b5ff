// SPDX-License-Identifier: Apache-2.0
// A BRDF made of a lambda, for tests.

#pragma once

#include <string>
#include <utility>

#include "brdf/brdf.h"
#include "brdf/merl_table.h"

namespace gonio {

class FunctionBrdf final : public Brdf {
 public:
  explicit FunctionBrdf(BrdfFunction function) : function_(std::move(function)) {}
  std::optional<Rgb> Eval(const HalfDiff& angles) const override { return function_(angles); }
  using Brdf::Eval;
  std::string name() const override { return "function"; }

 private:
  BrdfFunction function_;
};

}  // namespace gonio
