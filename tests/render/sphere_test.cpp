// SPDX-License-Identifier: Apache-2.0
#include "brdf/render/sphere.h"
