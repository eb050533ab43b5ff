// SPDX-License-Identifier: Apache-2.0
#include "brdf/rgl_table.h"
