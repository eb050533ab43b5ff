// SPDX-License-Identifier: Apache-2.0
// Pictures, drawn by gnuplot in a process of its own.

#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace gonio {

// Rows of numbers that a script calls `$name`. An empty row breaks a line in two; NaN is a missing
// number.
struct PlotTable {
  std::string name;  // letters, digits, underscores
  std::vector<std::vector<double>> rows;
};

struct Plot {
  std::string title;  // in words, for tooltips and screen readers; any text
  int width = 760;    // px; the picture scales, its fonts with it
  int height = 440;
  // gnuplot commands. They start from the house style: thin grey axes at the left and below, light
  // grid, UTF-8, enhanced text, fonts of 13 px.
  std::string script{};
  std::vector<PlotTable> tables{};
};

// One <svg> element, which can be a file or stand in an HTML page beside others: all its ids start
// with `id_prefix` (letters, digits, hyphens), it refers to nothing outside and needs no script.
// Takes some 30 ms. Throws std::runtime_error "gnuplot not found: ...", or "gnuplot: ..." if it
// fails.
std::string RenderSvg(const Plot& plot, const std::string& id_prefix);

// Writes the picture as a .png (with twice as many pixels as it is wide, for print) or .svg, whole
// or not at all. Throws as CheckPlotPath and RenderSvg do.
void WritePlot(const std::filesystem::path& path, const Plot& plot);
// Throws ConfigError "PATH: ..." unless it ends in .png or .svg: before anything is computed.
void CheckPlotPath(const std::filesystem::path& path);

// `text` with &, <, > and quotes escaped, as SVG and HTML want it.
std::string XmlText(const std::string& text);

// `text` as a gnuplot string that is shown as it is, unless the text is "enhanced".
std::string Quoted(const std::string& text);

}  // namespace gonio
