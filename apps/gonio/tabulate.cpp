// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/tabulate.h"

namespace gonio {

MerlTable Tabulate(const Brdf& brdf) {
  if (const auto* table = dynamic_cast<const MerlTable*>(&brdf)) return *table;
  return MerlTable::FromFunction(brdf.name(), [&](const HalfDiff& angles) {
    std::optional<Rgb> f_r = brdf.Eval(angles);
    // A colour that is not known (a fit that failed in it) is black in a table, not its neighbours'
    // end.
    if (f_r) *f_r = f_r->isFinite().select(f_r->max(0), 0.0);
    return f_r;
  });
}

}  // namespace gonio
