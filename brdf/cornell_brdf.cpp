// SPDX-License-Identifier: Apache-2.0
#include "brdf/cornell_brdf.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string_view>
#include <utility>

#include "brdf/csv_reader.h"
#include "core/error.h"
#include "core/units.h"

namespace gonio {
namespace {

constexpr int kMostWavelengths = 4096;
constexpr const char* kAngles[] = {"theta_i", "phi_i", "theta_s", "phi_s"};

class Reader {
 public:
  Reader(const std::string& text, const std::string& name, const WavelengthBands& bands)
      : rest_(text), name_(name), bands_(bands) {}

  CornellBrdf Read() {
    ReadWavelengths();
    for (const WavelengthBand& band : bands_) Require(band);
    while (NextLine()) {
      brdf_.samples.push_back(
          {.pose = static_cast<int>(brdf_.samples.size()), .sample = ReadSample()});
    }
    if (brdf_.samples.empty()) throw ConfigError(name_ + ": holds no samples");
    return std::move(brdf_);
  }

 private:
  [[noreturn]] void Fail(const std::string& complaint) const {
    throw ConfigError(fmt::format("{}:{}: {}", name_, line_, complaint));
  }

  [[noreturn]] void FailAt(std::size_t index, const std::string& what,
                           const std::string& complaint) const {
    Fail(fmt::format("number {} ({}): is \"{}\", {}", index + 1, what, words_[index], complaint));
  }

  double Finite(std::size_t index, const std::string& what) const {
    const auto number = ParseDouble(words_[index]);
    if (!number || !std::isfinite(*number)) FailAt(index, what, "must be a finite number");
    return *number;
  }

  // Splits the next line that is more than a comment into words; false at the end.
  bool NextLine() {
    while (!rest_.empty()) {
      const std::size_t end = rest_.find('\n');
      std::string_view line = rest_.substr(0, end);
      rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
      ++line_;
      const std::size_t comment = line.find('#');
      if (comment != std::string_view::npos) {
        if (brdf_.wavelengths_nm.empty()) KeepTitle(Trimmed(line.substr(comment + 1)));
        line = line.substr(0, comment);
      }
      line = Trimmed(line);
      if (line.empty()) continue;
      SplitAtBlanks(line);
      return true;
    }
    return false;
  }

  void KeepTitle(std::string_view comment) {
    if (comment.empty() || comment == "num wls" || comment == "wls") return;  // of the layout
    brdf_.title += fmt::format("{}{}", brdf_.title.empty() ? "" : "; ", comment);
  }

  void SplitAtBlanks(std::string_view line) {
    words_.clear();
    while (!line.empty()) {
      const std::size_t end = std::min(line.find_first_of(" \t"), line.size());
      words_.push_back(line.substr(0, end));
      line = Trimmed(line.substr(end));
    }
  }

  void ReadWavelengths() {
    if (!NextLine()) throw ConfigError(name_ + ": holds no number of wavelengths");
    const double count = Finite(0, "number of wavelengths");
    if (words_.size() != 1 || !(count >= 1 && count <= kMostWavelengths) ||
        count != std::floor(count)) {
      FailAt(0, "number of wavelengths",
             fmt::format("must be a whole number of 1 to {}, alone on its line", kMostWavelengths));
    }
    while (brdf_.wavelengths_nm.size() < count) {
      if (!NextLine()) {
        Fail(fmt::format("has {} wavelengths, not {}", brdf_.wavelengths_nm.size(), count));
      }
      for (std::size_t i = 0; i < words_.size(); ++i) {
        const double nm = Finite(i, "wavelength");
        if (!(nm > 0)) FailAt(i, "wavelength", "must be > 0");
        if (brdf_.wavelengths_nm.size() == count) {
          FailAt(i, "wavelength", fmt::format("there should be {} of them", count));
        }
        brdf_.wavelengths_nm.push_back(nm);
      }
    }
  }

  static bool Holds(const WavelengthBand& band, double nm) {
    return nm >= band.from_nm && nm <= band.to_nm;
  }

  void Require(const WavelengthBand& band) const {
    const std::vector<double>& all = brdf_.wavelengths_nm;
    if (std::any_of(all.begin(), all.end(), [&](double nm) { return Holds(band, nm); })) return;
    throw ConfigError(fmt::format(
        "{}: has no wavelength from {} to {} nm, only {} to {}", name_, band.from_nm, band.to_nm,
        *std::min_element(all.begin(), all.end()), *std::max_element(all.begin(), all.end())));
  }

  Eigen::Vector3d Direction(std::size_t theta_index) const {
    const double theta = Finite(theta_index, kAngles[theta_index]);
    if (!(std::abs(theta) < kPi / 2)) {
      FailAt(theta_index, kAngles[theta_index],
             "must be within -pi/2 .. pi/2; the direction lies below the horizon");
    }
    return FromSpherical(theta, Finite(theta_index + 1, kAngles[theta_index + 1]));
  }

  BrdfSample ReadSample() {
    const std::size_t wanted = std::size(kAngles) + brdf_.wavelengths_nm.size();
    if (words_.size() != wanted) {
      Fail(fmt::format("has {} numbers, not 4 angles and {} values", words_.size(),
                       brdf_.wavelengths_nm.size()));
    }
    BrdfSample sample;
    sample.directions = {Direction(0), Direction(2)};
    std::array<int, kChannels> values{};
    std::array<bool, kChannels> zero;
    zero.fill(true);
    for (std::size_t i = std::size(kAngles); i < wanted; ++i) {
      const double nm = brdf_.wavelengths_nm[i - std::size(kAngles)];
      const double f_r = Finite(i, fmt::format("{} nm", nm));
      for (int c = 0; c < kChannels; ++c) {
        if (!Holds(bands_[c], nm)) continue;
        sample.f_r[c] += f_r;
        zero[c] = zero[c] && f_r == 0;
        ++values[c];
      }
    }
    for (int c = 0; c < kChannels; ++c) sample.f_r[c] /= values[c];
    if (!sample.f_r.isFinite().all()) Fail("has values that are too large");
    sample.sigma =
        kDefaultRelativeSigma * sample.f_r.abs() + kCornellFloor / sample.directions.cos_theta_i();
    brdf_.zeros += static_cast<int>(std::count(zero.begin(), zero.end(), true));
    return sample;
  }

  std::string_view rest_;
  const std::string& name_;
  const WavelengthBands& bands_;
  int line_ = 0;
  std::vector<std::string_view> words_;
  CornellBrdf brdf_;
};

}  // namespace

CornellBrdf ParseCornell(const std::string& text, const std::string& name,
                         const WavelengthBands& bands) {
  return Reader(text, name, bands).Read();
}

}  // namespace gonio
