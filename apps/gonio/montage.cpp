// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/montage.h"

#include <fmt/format.h>

#include <algorithm>

#include "apps/gonio/plot.h"
#include "core/check.h"
#include "core/error.h"

namespace gonio {
namespace {

constexpr int kGap = 6;        // px between tiles
constexpr int kTop = 26;       // px for a row's labels above it
constexpr int kPerLetter = 8;  // px of the labels at the left

// A file that is removed when it is no longer needed.
class Scratch {
 public:
  explicit Scratch(std::filesystem::path path) : path_(std::move(path)) {}
  ~Scratch() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// Where things stand, in px from the top left.
struct Layout {
  int tile = 0, left = 0, columns = 0, rows = 0;
  int width() const { return left + columns * (tile + kGap); }
  int height() const { return rows * (kTop + tile + kGap); }
  int x(std::size_t column) const { return left + static_cast<int>(column) * (tile + kGap); }
  int y(std::size_t row) const { return kTop + static_cast<int>(row) * (kTop + tile + kGap); }
};

Layout LayOut(const std::vector<MontageRow>& rows) {
  Layout layout{.rows = static_cast<int>(rows.size())};
  std::size_t letters = 0;
  for (const MontageRow& row : rows) {
    letters = std::max(letters, row.label.size());
    layout.columns = std::max(layout.columns, static_cast<int>(row.tiles.size()));
    for (const MontageTile& tile : row.tiles) {
      if (layout.tile == 0) layout.tile = tile.tone_mapped.width;
      GONIO_CHECK(tile.tone_mapped.width == layout.tile && tile.tone_mapped.height == layout.tile,
                  "tiles of one size");
    }
  }
  layout.left = static_cast<int>(letters) * kPerLetter + 2 * kGap;
  return layout;
}

Image Tiles(const std::vector<MontageRow>& rows, const Layout& layout) {
  Image image(layout.width(), layout.height());
  for (Eigen::Array3f& pixel : image.pixels) pixel.setOnes();
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (std::size_t t = 0; t < rows[r].tiles.size(); ++t) {
      const Image& tile = rows[r].tiles[t].tone_mapped;
      for (int y = 0; y < tile.height; ++y) {
        for (int x = 0; x < tile.width; ++x) {
          image.at(layout.x(t) + x, layout.y(r) + y) = tile.at(x, y);
        }
      }
    }
  }
  return image;
}

}  // namespace

void WriteMontage(const std::filesystem::path& path, const std::vector<MontageRow>& rows) {
  if (path.extension() != ".png") throw ConfigError(path.string() + ": must be a .png");
  const Layout layout = LayOut(rows);
  const Scratch tiles(path.parent_path() / (path.stem().string() + ".tiles.png"));
  WritePng(tiles.path(), Tiles(rows, layout));
  Plot plot{.title = "Renders", .width = layout.width(), .height = layout.height()};
  plot.script = fmt::format(
      "unset border\nunset tics\nunset key\nunset grid\nset lmargin 0\nset rmargin 0\n"
      "set tmargin 0\nset bmargin 0\nset xrange [0:{0}]\nset yrange [0:{1}]\n",
      layout.width(), layout.height());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const int middle = layout.height() - layout.y(r) - layout.tile / 2;
    plot.script += fmt::format("set label {} at {},{} left front noenhanced\n",
                               Quoted(rows[r].label), kGap, middle);
    for (std::size_t t = 0; t < rows[r].tiles.size(); ++t) {
      plot.script += fmt::format("set label {} at {},{} center front noenhanced\n",
                                 Quoted(rows[r].tiles[t].label), layout.x(t) + layout.tile / 2,
                                 layout.height() - layout.y(r) + kTop / 2);
    }
  }
  // gnuplot's pixels are centred on whole numbers.
  plot.script +=
      fmt::format("plot {} binary filetype=png origin=(0.5,0.5) dx=1 dy=1 with rgbimage\n",
                  Quoted(tiles.path().string()));
  WritePlot(path, plot);
}

}  // namespace gonio
