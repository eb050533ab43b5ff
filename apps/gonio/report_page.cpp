// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/report_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "apps/gonio/progress.h"
#include "apps/gonio/report_figures.h"
#include "apps/gonio/report_imported.h"
#include "apps/gonio/report_style.h"
#include "core/sha256.h"

namespace gonio {
namespace {

constexpr double kSlicesDeg[] = {5, 30, 60, 75};
constexpr std::size_t kRowsShown = 20;

std::string Section(const std::string& id, const std::string& title, const std::string& body) {
  return fmt::format("<section id=\"{}\">\n<h2>{}</h2>\n{}</section>\n", id, title, body);
}

// Sets the symbols of our own captions: "f_r", "θ_h". Never for names a user chose.
std::string Typeset(std::string html) {
  constexpr std::pair<const char*, const char*> kSymbols[] = {{"f_r", "<i>f</i><sub>r</sub>"},
                                                              {"θ_h", "<i>θ</i><sub>h</sub>"},
                                                              {"θ_d", "<i>θ</i><sub>d</sub>"},
                                                              {"φ_d", "<i>φ</i><sub>d</sub>"},
                                                              {"cos^γ", "cos<sup><i>γ</i></sup>"}};
  for (const auto& [plain, set] : kSymbols) {
    const std::string from = plain;
    const std::string to = set;
    for (std::size_t at = html.find(from); at != std::string::npos;
         at = html.find(from, at + to.size())) {
      html.replace(at, from.size(), to);
    }
  }
  return html;
}

// "2024-05-01T12:00:00Z" for people.
std::string Date(std::string utc) {
  if (utc.size() == 20 && utc[10] == 'T' && utc[19] == 'Z') {
    utc[10] = ' ';
    utc.replace(16, 4, " UTC");
  }
  return utc;
}

// `text`: our own, HTML.
std::string Caption(const std::string& text) {
  return "<p class=\"caption\">" + Typeset(text) + "</p>\n";
}

std::string FigureHtml(const Figure& figure, const std::string& id) {
  const std::string caption =
      figure.caption.empty()
          ? ""
          : "<figcaption>" + Typeset(XmlText(figure.caption)) + "</figcaption>\n";
  return fmt::format("<figure id=\"{}\">\n{}{}</figure>\n", id, RenderSvg(figure.plot, id + "-"),
                     caption);
}

// Two columns: what, and what it is.
std::string FactTable(const std::vector<std::pair<std::string, std::string>>& rows) {
  std::string html = "<table class=\"facts\">\n";
  for (const auto& [name, text] : rows) {
    if (text.empty()) continue;
    html += fmt::format("<tr><th>{}</th><td>{}</td></tr>\n", XmlText(name), XmlText(text));
  }
  return html + "</table>\n";
}

std::string Tile(const std::string& number, const std::string& what, const std::string& detail) {
  return fmt::format("<div class=\"tile\"><b>{}</b><span>{}</span><small>{}</small></div>\n",
                     XmlText(number), XmlText(what), XmlText(detail));
}

std::string MaterialName(const ReportFacts& facts) {
  if (facts.truth) return facts.truth->name();
  if (IsImported(facts)) {
    return std::filesystem::path(ImportedFact(facts, "file")).stem().string();
  }
  const std::filesystem::path material = facts.session.info.material_path;
  return material.empty() ? std::filesystem::absolute(facts.dir).filename().string()
                          : material.stem().string();
}

// Empty for a light without colours.
std::string LightText(const ReportFacts& facts) {
  if (!facts.rig.by_colour) return "";
  std::string frames;
  for (const LightColour colour : kLightColours) {
    const auto found = facts.session.frames_by_colour.find(ToString(colour));
    const int count = found == facts.session.frames_by_colour.end() ? 0 : found->second;
    frames += fmt::format("{}{} in {}", frames.empty() ? "" : ", ", count, ToString(colour));
  }
  return fmt::format("one colour after the other{}: {} frames",
                     facts.rig.filter_wheel ? ", by a filter wheel" : "", frames);
}

std::string Percent(double share) {
  return fmt::format("{:.{}f} %", 100 * share, share < 0.1 || share > 0.9 ? 1 : 0);
}

// ---- the sections

std::string Header(const ReportFacts& facts) {
  const SessionInfo& info = facts.session.info;
  if (IsImported(facts)) {
    return fmt::format(
        "<header>\n<p class=\"kind\">Goniopilot session report</p>\n<h1>{}</h1>\n"
        "<p>Imported from “{}” on {}</p>\n</header>\n",
        XmlText(MaterialName(facts)), XmlText(ImportedFact(facts, "file")),
        XmlText(Date(info.created_utc)));
  }
  return fmt::format(
      "<header>\n<p class=\"kind\">Goniopilot session report</p>\n<h1>{}</h1>\n"
      "<p>{} plan on the rig “{}”, seed {}, {}</p>\n</header>\n",
      XmlText(MaterialName(facts)), XmlText(facts.plan.name), XmlText(facts.rig.name), info.seed,
      XmlText(Date(info.created_utc)));
}

std::string ImportedTiles(const ReportFacts& facts) {
  const auto samples = static_cast<double>(facts.session.Samples().size());
  const int negative = NegativeSamples(facts.session);
  std::string html = "<div class=\"tiles\">\n";
  html += Tile(fmt::format("{:.0f}", samples), "samples",
               fmt::format("at {} poses", facts.session.poses.size()));
  html += Tile(samples > 0 ? Percent(negative / samples) : "0 %", "below zero",
               fmt::format("{} samples, kept", negative));
  html += Tile(fmt::format("{}", UnusableSamples(facts.session)), "not fitted",
               "kept, but marked as unusable");
  if (facts.times.total > Seconds(0)) {
    html += Tile(ForPeople(facts.times.total), "by its clock", "from the first to the last sample");
  }
  return html + "</div>\n";
}

std::string Tiles(const ReportFacts& facts) {
  if (IsImported(facts)) return ImportedTiles(facts);
  const auto poses = static_cast<double>(facts.session.poses.size());
  std::string html = "<div class=\"tiles\">\n";
  if (facts.male) {
    html += Tile(fmt::format("{:.4f}", *facts.male), "error (MALE)", "against the known material");
  }
  if (!facts.planner_error.empty()) {
    html += Tile(fmt::format("{:.4f}", facts.planner_error.back().error), "expected error",
                 "by the planner, not knowing the truth");
  }
  html += Tile(fmt::format("{}", facts.session.poses.size()), "poses",
               fmt::format("{} of a dense scan's {}", Percent(poses / facts.dense.poses),
                           facts.dense.poses));
  html += Tile(ForPeople(facts.times.total), "on the rig",
               fmt::format("dense scan {}, 30 % scan {}", ForPeople(facts.dense.total()),
                           ForPeople(facts.thinned.total())));
  const double saved = 1 - facts.times.total / facts.dense.total();
  if (saved > 0) html += Tile(Percent(saved), "of the time saved", "compared with the dense scan");
  return html + "</div>\n";
}

std::string RemarkList(const ReportFacts& facts) {
  const std::vector<std::string> remarks = Remarks(facts);
  if (remarks.empty()) {
    return "<p class=\"good\">Nothing unusual: no warnings about this session.</p>\n";
  }
  std::string html = "<ul class=\"warnings\">\n";
  for (const std::string& remark : remarks) html += "<li>" + XmlText(remark) + "</li>\n";
  return html + "</ul>\n";
}

std::string Summary(const ReportFacts& facts) {
  const SessionInfo& info = facts.session.info;
  const auto& end = facts.session.end;
  std::string fit = facts.no_fit;
  if (facts.fit) {
    const FitSummary& s = facts.fit->summary();
    const DsbrdfShape& shape = facts.fit->model().shape();
    fit = fmt::format("{} lobes × {} knots to {} readings; model error {:.1f} %", shape.lobes,
                      shape.knots, s.residuals, 100 * s.model_error);
  }
  if (IsImported(facts)) {
    std::vector<std::pair<std::string, std::string>> rows = SourceRows(facts);
    rows.insert(rows.end(), {{"Prior", info.prior_name}, {"Fit", fit}});
    return FactTable(rows);
  }
  return FactTable({
      {"Material", info.material_path.empty() ? "a real sample" : info.material_path},
      {"Rig", facts.rig.name + (facts.rig.simulated ? " (simulated)" : "")},
      {"Light", LightText(facts)},
      {"Plan", facts.plan.name},
      {"Prior", info.prior_name},
      {"Seed", std::to_string(info.seed)},
      {"Started", Date(info.created_utc)},
      {"Ended", end ? end->outcome + ": " + end->reason : "no end in the log"},
      {"Poses",
       fmt::format("{} measured, {} refused", facts.session.poses.size(), facts.refusals.size())},
      {"Fit", fit},
  });
}

std::string Slices(const ReportFacts& facts) {
  std::string html = "<div class=\"grid\">\n";
  for (const double deg : kSlicesDeg) {
    html += FigureHtml(SliceFigure(facts, RadFromDeg(deg)), fmt::format("slice-{:.0f}", deg));
  }
  std::string caption =
      "BRDF f_r without cosine, at four difference angles θ_d, per colour channel. Lines: the fit; "
      "bands: its ±2σ. ";
  if (facts.truth) caption += "Dashed: the known material at φ_d = 90°. ";
  caption += fmt::format(
      "Dots: samples measured within ±{:.0f}° of θ_d at any φ_d, with bars of ±2σ, carried along "
      "the fit to θ_d, so that their distance from the line is their residual; rings are channels "
      "that coincide; triangles at the bottom: samples that are zero or below in some channel. "
      "Shaded: directions beyond 80° from the normal (at φ_d = 90°), which errors "
      "do "
      "not count. The vertical axis is logarithmic.",
      DegFromRad(kSliceReach));
  html += "</div>\n" + Caption(caption);
  return html;
}

std::string TimeTable(const ReportFacts& facts) {
  const SessionTimes& t = facts.times;
  const auto row = [](const char* name, Seconds dense, Seconds thinned, Seconds session,
                      bool planned) {
    const auto cell = [](Seconds time, bool known) { return known ? ForPeople(time) : "–"; };
    return fmt::format("<tr><th>{}</th><td>{}</td><td>{}</td><td>{}</td></tr>\n", name,
                       cell(dense, planned), cell(thinned, planned), ForPeople(session));
  };
  const TimeEstimate& d = facts.dense;
  const TimeEstimate& h = facts.thinned;
  return "<table class=\"numbers\">\n<tr><th></th><th>dense scan</th><th>30 % of its rows</th>"
         "<th>this session</th></tr>\n" +
         row("Homing", {}, {}, t.homing, false) +
         row("Travel", d.travel, h.travel, t.travel, true) +
         row("Settling", d.settling, h.settling, t.settling, true) +
         row("Exposure and read-out", d.exposing, h.exposing, t.exposing, true) +
         row("Other (refused poses)", {}, {}, t.other, false) +
         row("Total", d.total(), h.total(), t.total, true) + "</table>\n";
}

// How far a planner's idea of time can be trusted on this rig.
std::string PredictedAndActual(const PredictedTimes& times) {
  if (times.poses == 0 || times.predicted <= Seconds::zero()) return {};
  return fmt::format(
      "<p>For its {} poses after the first, the rig file's speeds and overheads predict {} and "
      "they "
      "took {}: {:+.1f} %, {:.2g} s rms for a pose. <code>gonio calibrate time</code> learns them "
      "from sessions.</p>\n",
      times.poses, ForPeople(times.predicted), ForPeople(times.actual),
      100 * (times.actual / times.predicted - 1), times.rms.count());
}

std::string Durations(const ReportFacts& facts) {
  return FigureHtml(DurationFigure(facts), "durations") +
         Caption(fmt::format(
             "Time on the rig. The scans are estimates for the same rig: every reachable pose of "
             "the 90 × 90 raster (or of 30 % of its θ_h rows), to and fro, exposing "
             "{:.3g} s a pose as this session did on average; homing is not counted.",
             facts.times.exposing_per_pose.count())) +
         TimeTable(facts) + PredictedAndActual(facts.predicted_times);
}

// "0.1834 ± 0.0023": two digits of the uncertainty, and f_r to the same place.
std::string Reading(double f_r, double sigma, bool imported) {
  if (!std::isfinite(sigma)) {
    return imported ? fmt::format("{:.4g} <i>not fitted</i>", f_r) : "saturated";
  }
  const int places = std::clamp(1 - static_cast<int>(std::floor(std::log10(sigma))), 0, 9);
  return fmt::format("{:.{}f} <i>± {:.{}f}</i>", f_r, places, sigma, places);
}

std::string SampleRow(const MeasuredPose& pose, const BrdfSample& sample, bool imported) {
  const HalfDiff angles = ToHalfDiff(sample.directions);
  std::string row = fmt::format(
      "<tr><td>{}</td><td class=\"text\">{}</td><td>{:.2f}</td><td>{:.2f}</td><td>{:.1f}</td>",
      pose.pose, XmlText(pose.reason), DegFromRad(angles.theta_h), DegFromRad(angles.theta_d),
      DegFromRad(angles.phi_d));
  for (int c = 0; c < kChannels; ++c) {
    row += "<td>" + Reading(sample.f_r[c], sample.sigma[c], imported) + "</td>";
  }
  return row + fmt::format("<td>{}</td><td>{:.1f}</td></tr>\n", pose.frames, pose.end.count());
}

std::string Samples(const ReportFacts& facts) {
  std::vector<std::string> rows;
  for (const MeasuredPose& pose : facts.session.poses) {
    for (const BrdfSample& sample : pose.samples)
      rows.push_back(SampleRow(pose, sample, IsImported(facts)));
  }
  const std::size_t shown = std::min(rows.size(), kRowsShown);
  std::string html = Typeset(
      "<div class=\"wide\"><table class=\"numbers\">\n<tr><th>pose</th><th class=\"text\">why</th>"
      "<th>θ_h [deg]</th><th>θ_d [deg]</th><th>φ_d [deg]</th><th>f_r red [1/sr]</th>"
      "<th>f_r green [1/sr]</th><th>f_r blue [1/sr]</th><th>frames</th><th>time [s]</th></tr>\n");
  for (std::size_t i = 0; i < shown; ++i) html += rows[i];
  // The path is not ours to typeset.
  return html +
         fmt::format(
             "</table></div>\n<p class=\"caption\">The first {} of {} samples with their standard "
             "uncertainty. All of them: <code>gonio export {} --to csv SAMPLES.csv</code></p>\n",
             shown, rows.size(), XmlText(facts.dir.string()));
}

std::string Refusals(const ReportFacts& facts) {
  std::string html = Typeset(
      "<table class=\"numbers\">\n<tr><th>θ_h [deg]</th><th>θ_d [deg]</th><th>φ_d [deg]</th>"
      "<th class=\"text\">why</th></tr>\n");
  const std::size_t shown = std::min(facts.refusals.size(), kRowsShown);
  for (std::size_t i = 0; i < shown; ++i) {
    const Refusal& r = facts.refusals[i];
    html += fmt::format(
        "<tr><td>{:.2f}</td><td>{:.2f}</td><td>{:.1f}</td><td class=\"text\">{}</td></tr>\n",
        DegFromRad(r.angles.theta_h), DegFromRad(r.angles.theta_d), DegFromRad(r.angles.phi_d),
        XmlText(r.message));
  }
  html += "</table>\n";
  if (shown < facts.refusals.size()) {
    html += Caption(fmt::format("The first {} of {}.", shown, facts.refusals.size()));
  }
  return html;
}

std::string Identities(const ReportFacts& facts) {
  const SessionInfo& info = facts.session.info;
  const bool imported = IsImported(facts);
  std::vector<std::pair<std::string, std::string>> rows = {
      {"Session", std::filesystem::absolute(facts.dir).lexically_normal().string()},
      {imported ? "Imported with" : "Measured with", "gonio " + info.gonio_version},
      {"Reported with", "gonio " GONIO_VERSION},
      {"Imported file, SHA-256", ImportedFact(facts, "sha256")},
      {"Rig file, SHA-256", imported ? "" : Sha256(info.rig_text)},
      {"Plan file, SHA-256", Sha256(info.plan_text)},
      {"Prior, SHA-256", info.prior_sha256},
      {"Material file, SHA-256", info.material_sha256},
  };
  std::string devices;
  for (const auto& [role, identity] : info.devices) {
    if (!devices.empty()) devices += ", ";
    devices += role == identity ? role : fmt::format("{}: {}", role, identity);
  }
  rows.emplace_back("Devices", devices);
  return FactTable(rows);
}

}  // namespace

std::string ReportPage(const ReportFacts& facts) {
  std::string body = Header(facts) + Tiles(facts) + RemarkList(facts);
  body += Section("session", "The session", Summary(facts));
  body += Section("poses", "Where it measured", FigureHtml(PoseMapFigure(facts), "map"));
  if (IsImported(facts)) {
    if (const std::optional<Figure> readings = ReadingsFigure(facts)) {
      body += Section("readings", "Readings as they came", FigureHtml(*readings, "scans"));
    }
  }
  if (facts.fit) body += Section("slices", "Predicted reflectance", Slices(facts));
  if (HasErrorFigure(facts)) {
    body += Section("error", "Error over the number of poses",
                    FigureHtml(ErrorFigure(facts), "errors"));
  }
  if (!IsImported(facts)) body += Section("time", "Time, planned and dense", Durations(facts));
  if (facts.fit) {
    body += Section("lobes", "The lobes of the fit", FigureHtml(LobeFigure(facts), "lobe"));
  }
  body += Section("samples", "Samples", Samples(facts));
  if (!facts.incidents.empty()) {
    body += Section("incidents", "What came between", IncidentTable(facts.incidents));
  }
  if (!facts.refusals.empty()) body += Section("refused", "Refused poses", Refusals(facts));
  body += Section("identities", "What made this", Identities(facts));
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>{}: Goniopilot session report</title>\n<style>\n{}</style>\n</head>\n<body>\n"
      "<main>\n{}</main>\n</body>\n</html>\n",
      XmlText(MaterialName(facts)), kReportStyle, body);
}

}  // namespace gonio
