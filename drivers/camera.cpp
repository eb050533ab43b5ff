// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera.h"

#include <algorithm>

#include "core/check.h"

namespace gonio {

const char* ToString(PixelLayout layout) {
  switch (layout) {
    case PixelLayout::kMono:
      return "mono";
    case PixelLayout::kRgb:
      return "rgb";
    case PixelLayout::kBayerRg:
      return "bayer-rg";
    case PixelLayout::kBayerGr:
      return "bayer-gr";
    case PixelLayout::kBayerGb:
      return "bayer-gb";
    case PixelLayout::kBayerBg:
      return "bayer-bg";
  }
  return "?";
}

PixelLayout ReadPixelLayout(const ConfigNode& node, std::string_view key) {
  std::vector<std::string> names;
  for (const PixelLayout layout : kPixelLayouts) names.emplace_back(ToString(layout));
  const std::string name = node.Choice(key, names);
  return kPixelLayouts[std::find(names.begin(), names.end(), name) - names.begin()];
}

int CountsPerPixel(PixelLayout layout) { return layout == PixelLayout::kRgb ? 3 : 1; }

int BayerChannel(PixelLayout layout, int x, int y) {
  // Red stands at an even or odd column and row, blue at the others.
  int red_x = 0;
  int red_y = 0;
  switch (layout) {
    case PixelLayout::kBayerRg:
      break;
    case PixelLayout::kBayerGr:
      red_x = 1;
      break;
    case PixelLayout::kBayerGb:
      red_y = 1;
      break;
    case PixelLayout::kBayerBg:
      red_x = red_y = 1;
      break;
    default:
      GONIO_CHECK(false, "not a Bayer mosaic");
  }
  const bool red_column = (x & 1) == red_x;
  const bool red_row = (y & 1) == red_y;
  if (red_column && red_row) return 0;
  return red_column || red_row ? 1 : 2;
}

}  // namespace gonio
