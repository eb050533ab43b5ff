// SPDX-License-Identifier: Apache-2.0
// A reflectance as a table, for those who ask it a million times.

#pragma once

#include "brdf/brdf.h"
#include "brdf/merl_table.h"

namespace gonio {

// A table of `brdf` at the centres of a MERL table's cells; a MerlTable is itself. Negative values
// (colours out of gamut) become zero: a table holds none. Takes 0.2 to 2 s.
MerlTable Tabulate(const Brdf& brdf);

}  // namespace gonio
