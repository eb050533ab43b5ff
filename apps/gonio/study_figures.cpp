// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/study_figures.h"
