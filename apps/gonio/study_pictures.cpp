// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/study_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "apps/gonio/fit_figures.h"
#include "apps/gonio/montage.h"
#include "apps/gonio/plot.h"
#include "apps/gonio/study_figures.h"
#include "apps/gonio/summary.h"
#include "apps/gonio/tabulate.h"
#include "brdf/open.h"
#include "brdf/render/environment.h"
#include "brdf/render/sphere.h"

namespace gonio {
namespace {

constexpr int kTile = 192;     // px
constexpr int kSamples = 192;  // for each pixel under the sky

std::string DensityLabel(int keep_every) {
  return keep_every == 1 ? "full density" : fmt::format("1/{}", keep_every);
}

// One material of the montage: the reference and what was fitted to it at each density.
struct Exhibit {
  std::string name;
  MerlTable reference;
  std::vector<std::unique_ptr<LobeModel>> fits;  // one for each keep_every; null: not fitted
};

Exhibit Prepare(const StudyConfig& study, const std::filesystem::path& path) {
  Exhibit exhibit{path.stem().string(), Tabulate(*OpenBrdf(path)), {}};
  TableFitOptions options;
  options.method = study.montage.method;
  options.lobes = study.lobes;
  options.slices.step = study.slice_step;
  for (const int every : study.montage.keep_every) {
    options.slices.keep_every = every;
    exhibit.fits.push_back(FitTable(exhibit.reference, options).model);
  }
  return exhibit;
}

class Montage {
 public:
  explicit Montage(const StudyConfig& study) : study_(study) {
    render_.size = kTile;
    render_.samples = kSamples;
    render_.threads = AllCores().threads;
  }

  MontageRow Row(const Exhibit& exhibit, const std::string& light) const {
    const Image reference = Render(exhibit.reference, light);
    const double exposure = AutoExposure(reference);
    MontageRow row{exhibit.name, {}};
    row.tiles.push_back({"reference", ToneMap(reference, exposure)});
    for (std::size_t i = 0; i < exhibit.fits.size(); ++i) {
      if (!exhibit.fits[i]) continue;
      row.tiles.push_back({DensityLabel(study_.montage.keep_every[i]),
                           ToneMap(Render(Tabulate(*exhibit.fits[i]), light), exposure)});
    }
    return row;
  }

 private:
  Image Render(const Brdf& brdf, const std::string& light) const {
    return light == "env" ? RenderUnder(brdf, sky_, render_) : RenderUnderPoint(brdf, render_);
  }

  const StudyConfig& study_;
  RenderOptions render_;
  Environment sky_ = Environment::Sky();
};

void DrawFit(const Exhibit& exhibit, const std::filesystem::path& dir) {
  if (exhibit.fits.empty() || !exhibit.fits.front()) return;
  const LobeModel& fit = *exhibit.fits.front();
  constexpr int kGreen = 1;
  if (fit.LobesAt(0, kGreen).empty()) return;
  WritePlot(dir / ("slice-" + exhibit.name + ".svg"),
            LobesPlot(fit, &exhibit.reference, {.theta_d = RadFromDeg(5.5), .channel = kGreen}));
  WritePlot(dir / ("error-map-" + exhibit.name + ".png"),
            ErrorMapPlot(exhibit.reference, fit, kGreen));
}

}  // namespace

void WriteStudyPictures(const StudyConfig& study,
                        const std::vector<std::filesystem::path>& materials,
                        const StudyResult& result, const std::filesystem::path& dir) {
  const std::filesystem::path figures = dir / "figures";
  std::filesystem::create_directories(figures);
  const bool any = std::any_of(result.cells.begin(), result.cells.end(),
                               [](const StudyCell& cell) { return cell.failure.empty(); });
  if (!any) return;
  const Plot density = DensityPlot(result, "");
  WritePlot(figures / "density.svg", density);
  WritePlot(figures / "density.png", density);

  std::vector<Exhibit> exhibits;
  for (const std::string& name : study.montage.materials) {
    const auto found =
        std::find_if(materials.begin(), materials.end(),
                     [&](const std::filesystem::path& path) { return path.stem() == name; });
    if (found != materials.end()) exhibits.push_back(Prepare(study, *found));
  }
  if (exhibits.empty()) return;
  const Montage montage(study);
  for (const std::string& light : study.montage.lights) {
    std::vector<MontageRow> rows;
    for (const Exhibit& exhibit : exhibits) rows.push_back(montage.Row(exhibit, light));
    WriteMontage(figures / ("montage-" + light + ".png"), rows);
  }
  for (const Exhibit& exhibit : exhibits) DrawFit(exhibit, figures);
}

}  // namespace gonio
