// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/plot.h"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <system_error>

#include "core/error.h"
#include "core/file.h"

namespace gonio {
namespace {

constexpr const char* kHouseStyle = R"(set encoding utf8
set border 3 linecolor '#7b8794' linewidth 1
set tics nomirror out scale 0.6 textcolor '#3e4c59'
set grid linecolor '#e4e7eb' linewidth 1 linetype 1
set xlabel offset 0,0.3 textcolor '#1f2933'
set ylabel textcolor '#1f2933'
set key textcolor '#1f2933' samplen 2 Left reverse
set style fill solid noborder
)";

std::string Reason(int error) { return std::generic_category().message(error); }

// Without a name, gone when closed. Between us and gnuplot there are files and no pipes, so that
// neither ever waits for the other to read.
class TempFile {
 public:
  TempFile() : file_(std::tmpfile()) {
    if (!file_) throw std::runtime_error("gnuplot: no temporary file: " + Reason(errno));
  }
  int fd() const { return fileno(file_.get()); }

  void Fill(const std::string& text) {
    errno = 0;
    if (std::fwrite(text.data(), 1, text.size(), file_.get()) != text.size() ||
        std::fflush(file_.get()) != 0) {
      throw std::runtime_error("gnuplot: temporary file: cannot write: " + Reason(errno));
    }
    std::rewind(file_.get());
  }

  std::string Text() {
    std::rewind(file_.get());
    std::string text;
    char buffer[1 << 16];
    while (const std::size_t n = std::fread(buffer, 1, sizeof buffer, file_.get())) {
      text.append(buffer, n);
    }
    return text;
  }

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::unique_ptr<std::FILE, Close> file_;
};

// The last line that says something: gnuplot first repeats the command it did not understand.
std::string LastLine(const std::string& text) {
  std::istringstream lines(text);
  std::string last = "failed";
  for (std::string line; std::getline(lines, line);) {
    const std::size_t first = line.find_first_not_of(" \t");
    if (first != std::string::npos) last = line.substr(first);
  }
  return last;
}

int Wait(pid_t child) {
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) throw std::runtime_error("gnuplot: cannot wait for it: " + Reason(errno));
  }
  return status;
}

// What gnuplot prints when it runs `script`.
std::string RunGnuplot(const std::string& script) {
  TempFile in;
  TempFile out;
  TempFile err;
  in.Fill(script);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, in.fd(), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&files, out.fd(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files, err.fd(), STDERR_FILENO);
  // Default settings: a user's own .gnuplot must not change our pictures.
  char name[] = "gnuplot";
  char settings[] = "--default-settings";
  char from_stdin[] = "-";
  char* const arguments[] = {name, settings, from_stdin, nullptr};
  pid_t child = 0;
  const int error = posix_spawnp(&child, name, &files, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&files);
  if (error == ENOENT) throw std::runtime_error("gnuplot not found: apt install gnuplot-nox");
  if (error != 0) throw std::runtime_error("gnuplot: cannot start: " + Reason(error));
  const int status = Wait(child);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    throw std::runtime_error("gnuplot: " + LastLine(err.Text()));
  }
  return out.Text();
}

void AppendTable(const PlotTable& table, std::string* script) {
  auto out = std::back_inserter(*script);
  fmt::format_to(out, "${} << EOD\n", table.name);
  for (const std::vector<double>& row : table.rows) {
    for (const double number : row) {
      if (std::isfinite(number)) {
        fmt::format_to(out, "{:.7g} ", number);
      } else {
        fmt::format_to(out, "NaN ");
      }
    }
    *script += '\n';
  }
  *script += "EOD\n";
}

void ReplaceAll(const std::string& from, const std::string& to, std::string* text) {
  for (std::size_t at = text->find(from); at != std::string::npos; at = text->find(from, at)) {
    text->replace(at, from.size(), to);
    at += to.size();
  }
}

// gnuplot names every curve, and titles them "gnuplot_plot_7", which browsers show as tooltips.
void RemoveElements(const std::string& tag, std::string* svg) {
  const std::string close = "</" + tag + ">";
  for (std::size_t at = svg->find("<" + tag + ">"); at != std::string::npos;
       at = svg->find("<" + tag + ">", at)) {
    svg->erase(at, svg->find(close, at) + close.size() - at);
  }
}

// gnuplot gives the same ids to every picture; in one page the first would win.
void PrefixIds(const std::string& prefix, std::string* svg) {
  for (const char* reference : {" id=\"", " id='", "href='#", "href=\"#", "url(#"}) {
    ReplaceAll(reference, reference + prefix, svg);
  }
}

std::string ScriptOf(const Plot& plot, const std::string& terminal) {
  std::string script = "set terminal " + terminal + "\n" + kHouseStyle;
  for (const PlotTable& table : plot.tables) AppendTable(table, &script);
  script += plot.script;
  // Leaving the terminal writes what it still holds, an SVG's closing tag for one.
  return script + "\nunset output\n";
}

// Twice the pixels, and everything drawn twice as large.
std::string RenderPng(const Plot& plot) {
  const std::string png = RunGnuplot(ScriptOf(
      plot, fmt::format("pngcairo size {},{} enhanced rounded fontscale 1 font 'sans-serif,13' "
                        "background '#ffffff'",
                        2 * plot.width, 2 * plot.height) +
                "\nset termoption fontscale 1.5\nset termoption linewidth 2\nset termoption "
                "pointscale 2"));
  if (!png.starts_with("\x89PNG")) {
    throw std::runtime_error("gnuplot: drew no picture (is the disk full?)");
  }
  return png;
}

}  // namespace

void CheckPlotPath(const std::filesystem::path& path) {
  if (path.extension() != ".png" && path.extension() != ".svg") {
    throw ConfigError(fmt::format("{}: has the extension \"{}\", must be .png or .svg",
                                  path.string(), path.extension().string()));
  }
}

void WritePlot(const std::filesystem::path& path, const Plot& plot) {
  CheckPlotPath(path);
  const std::string picture = path.extension() == ".svg" ? RenderSvg(plot, "") : RenderPng(plot);
  WriteFileAtomically(path, [&](std::ostream& out) { out << picture; });
}

std::string RenderSvg(const Plot& plot, const std::string& id_prefix) {
  std::string svg = RunGnuplot(
      ScriptOf(plot, fmt::format("svg size {},{} dynamic rounded enhanced font 'sans-serif,13'",
                                 plot.width, plot.height)));
  const std::size_t begin = svg.find("<svg");
  const std::size_t end = svg.rfind("</svg>");
  if (begin == std::string::npos || end == std::string::npos) {
    throw std::runtime_error("gnuplot: drew no picture (is the disk full?)");
  }
  svg = svg.substr(begin, end + 6 - begin) + "\n";
  RemoveElements("title", &svg);
  RemoveElements("desc", &svg);
  PrefixIds(id_prefix, &svg);
  const std::size_t inside = svg.find('>') + 1;
  svg.insert(inside, "\n<title>" + XmlText(plot.title) + "</title>");
  svg.insert(4, " role=\"img\"");
  return svg;
}

std::string XmlText(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string Quoted(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) {
    if (c == '\'') quoted += '\'';  // doubled: one apostrophe
    quoted += c == '\n' ? ' ' : c;
  }
  return quoted + "'";
}

}  // namespace gonio
