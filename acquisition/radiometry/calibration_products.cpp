// SPDX-License-Identifier: Apache-2.0
#include "acquisition/radiometry/calibration_products.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"

namespace gonio {
namespace {

CalibrationData Stamped(const char* kind, const CalibrationStamp& stamp) {
  CalibrationData data;
  data.kind = kind;
  data.created = stamp.created;
  data.format = stamp.format;
  data.temperature_c = stamp.temperature_c;
  return data;
}

// Reads a file and hands out what it holds; whatever nobody asked for is refused at the end.
class Product {
 public:
  Product(const std::filesystem::path& path, const char* kind, CalibrationDemand demand)
      : path_(path) {
    demand.kind = kind;
    data_ = ReadCalibration(path, demand);
  }

  MeasuredValue Number(const std::string& name) { return Take(&data_.estimates, name); }
  std::string Text(const std::string& name) { return Take(&data_.texts, name); }
  std::vector<double> List(const std::string& name) { return Take(&data_.lists, name); }
  SiteImage Image(const std::string& name) { return Take(&data_.images, name); }
  bool HasImage(const std::string& name) const { return data_.images.contains(name); }
  bool HasNumber(const std::string& name) const { return data_.estimates.contains(name); }
  const CalibrationData& data() const { return data_; }

  void Finish() const {
    const auto none = [&](const auto& map) {
      if (!map.empty()) Fail(map.begin()->first + ": nobody knows this");
    };
    none(data_.estimates);
    none(data_.texts);
    none(data_.lists);
    none(data_.images);
  }
  [[noreturn]] void Fail(const std::string& complaint) const {
    throw ConfigError(path_.string() + ": " + complaint);
  }

 private:
  template <typename T>
  T Take(std::map<std::string, T>* map, const std::string& name) {
    auto node = map->extract(name);
    if (node.empty()) Fail(name + ": is missing");
    return std::move(node.mapped());
  }

  const std::filesystem::path path_;
  CalibrationData data_;
};

CalibrationData StampedWithLight(const char* kind, const CalibrationStamp& stamp) {
  CalibrationData data = Stamped(kind, stamp);
  data.light = stamp.light;
  return data;
}

// Of the images of one flat field, whose names begin with `prefix`.
void PutFlat(const std::string& prefix, const FlatField& flat, CalibrationData* data) {
  data->format = flat.format;
  data->images[prefix + "response"] = flat.response;
  data->images[prefix + "sigma"] = flat.sigma;
}

FlatField TakeFlat(const std::string& prefix, Product* product) {
  FlatField flat;
  flat.format = product->data().format;
  flat.response = product->Image(prefix + "response");
  flat.sigma = product->Image(prefix + "sigma");
  const auto good = [](float response) { return std::isfinite(response); };
  if (!std::all_of(flat.response.begin(), flat.response.end(), good)) {
    product->Fail(prefix + "response: holds what is no number");
  }
  if (!std::all_of(flat.sigma.begin(), flat.sigma.end(), [](float s) { return s >= 0; })) {
    product->Fail(prefix + "sigma: must be >= 0");
  }
  return flat;
}

std::string ColourPrefix(std::size_t c) { return kChannelNames[c] + std::string("_"); }

std::string FitName(std::size_t i, const char* what) { return fmt::format("dark{}_{}", i, what); }

DarkFit ReadFit(Product* product, std::size_t i) {
  DarkFit fit;
  fit.temperature_c = product->Number(FitName(i, "temperature_c")).value;
  fit.read_variance = product->Number(FitName(i, "read_variance_counts2")).value;
  fit.bias = product->Image(FitName(i, "bias_counts"));
  fit.rate = product->Image(FitName(i, "rate_counts_s"));
  fit.noise = product->Image(FitName(i, "noise_counts"));
  const auto exposures = product->List(FitName(i, "exposures_s"));
  const auto frames = product->List(FitName(i, "frames"));
  const auto to_bias = product->List(FitName(i, "to_bias"));
  const auto to_rate = product->List(FitName(i, "to_rate_per_s"));
  const std::size_t n = exposures.size();
  if (frames.size() != n || to_bias.size() != n || to_rate.size() != n) {
    product->Fail(FitName(i, "exposures_s") + ": the lists differ in length");
  }
  for (std::size_t k = 0; k < n; ++k) {
    if (!(frames[k] >= 1)) product->Fail(FitName(i, "frames") + ": must be >= 1");
    fit.levels.push_back({exposures[k], static_cast<int>(frames[k]), to_bias[k], to_rate[k]});
  }
  return fit;
}

}  // namespace

void WriteSensor(const std::filesystem::path& path, const CalibrationStamp& stamp,
                 const SensorCalibration& sensor) {
  CalibrationData data = Stamped("photon-transfer", stamp);
  data.estimates["gain_e_per_count"] = sensor.gain;
  data.estimates["read_noise_e"] = sensor.read_noise;
  data.estimates["full_well_e"] = sensor.full_well;
  data.estimates["exposure_offset_s"] = sensor.exposure_offset;
  for (const LinearityKnot& knot : sensor.linearity.knots()) {
    data.lists["linearity_counts"].push_back(knot.counts);
    data.lists["linearity_factor"].push_back(knot.factor.value);
    data.lists["linearity_sigma"].push_back(knot.factor.sigma);
  }
  WriteCalibration(path, data);
}

SensorCalibration ReadSensor(const std::filesystem::path& path, CalibrationDemand demand) {
  Product product(path, "photon-transfer", std::move(demand));
  SensorCalibration sensor;
  sensor.gain = product.Number("gain_e_per_count");
  sensor.read_noise = product.Number("read_noise_e");
  sensor.full_well = product.Number("full_well_e");
  // Older files have none.
  if (product.HasNumber("exposure_offset_s")) {
    sensor.exposure_offset = product.Number("exposure_offset_s");
  }
  if (!(sensor.gain.value > 0)) product.Fail("gain_e_per_count: must be > 0");
  if (!(sensor.read_noise.value >= 0)) product.Fail("read_noise_e: must be >= 0");
  const auto counts = product.List("linearity_counts");
  const auto factor = product.List("linearity_factor");
  const auto sigma = product.List("linearity_sigma");
  if (factor.size() != counts.size() || sigma.size() != counts.size()) {
    product.Fail("linearity_counts: the lists differ in length");
  }
  std::vector<LinearityKnot> knots;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    knots.push_back({counts[i], {factor[i], sigma[i]}});
  }
  auto table = Linearity::FromKnots(std::move(knots));
  if (!table) product.Fail(table.error().message);
  sensor.linearity = std::move(table).value();
  product.Finish();
  return sensor;
}

void WriteDark(const std::filesystem::path& path, const DarkLibrary& library) {
  CalibrationData data = Stamped("dark", {library.created, library.format, std::nullopt});
  data.estimates["gain_e_per_count"] = {library.gain, 0};
  for (std::size_t i = 0; i < library.fits.size(); ++i) {
    const DarkFit& fit = library.fits[i];
    data.estimates[FitName(i, "temperature_c")] = {fit.temperature_c, 0};
    data.estimates[FitName(i, "read_variance_counts2")] = {fit.read_variance, 0};
    data.images[FitName(i, "bias_counts")] = fit.bias;
    data.images[FitName(i, "rate_counts_s")] = fit.rate;
    data.images[FitName(i, "noise_counts")] = fit.noise;
    for (const DarkFit::Level& level : fit.levels) {
      data.lists[FitName(i, "exposures_s")].push_back(level.exposure);
      data.lists[FitName(i, "frames")].push_back(level.frames);
      data.lists[FitName(i, "to_bias")].push_back(level.to_bias);
      data.lists[FitName(i, "to_rate_per_s")].push_back(level.to_rate);
    }
  }
  WriteCalibration(path, data);
}

DarkLibrary ReadDark(const std::filesystem::path& path, CalibrationDemand demand) {
  Product product(path, "dark", std::move(demand));
  DarkLibrary library;
  library.format = product.data().format;
  library.created = product.data().created;
  library.gain = product.Number("gain_e_per_count").value;
  if (!(library.gain > 0)) product.Fail("gain_e_per_count: must be > 0");
  while (library.fits.empty() || product.HasImage(FitName(library.fits.size(), "bias_counts"))) {
    library.fits.push_back(ReadFit(&product, library.fits.size()));
  }
  product.Finish();
  return library;
}

void WriteBadPixels(const std::filesystem::path& path, const CalibrationStamp& stamp,
                    const BadPixels& bad) {
  CalibrationData data = Stamped("bad-pixels", stamp);
  data.images["mask"] = SiteImage(bad.mask.begin(), bad.mask.end());
  WriteCalibration(path, data);
}

BadPixels ReadBadPixels(const std::filesystem::path& path, CalibrationDemand demand) {
  Product product(path, "bad-pixels", std::move(demand));
  constexpr int kAllBits = kHotPixel | kNoisyPixel | kDeadPixel;
  BadPixels bad;
  for (const float bits : product.Image("mask")) {
    if (!(bits >= 0 && bits <= kAllBits && bits == std::floor(bits))) {
      product.Fail(fmt::format("mask: holds {}, must be whole and at most {}", bits, kAllBits));
    }
    bad.mask.push_back(static_cast<std::uint8_t>(bits));
    bad.hot += (bad.mask.back() & kHotPixel) != 0;
    bad.noisy += (bad.mask.back() & kNoisyPixel) != 0;
    bad.dead += (bad.mask.back() & kDeadPixel) != 0;
  }
  product.Finish();
  return bad;
}

void WriteFlatField(const std::filesystem::path& path, const CalibrationStamp& stamp,
                    const FlatField& flat) {
  CalibrationData data = Stamped("flat-field", stamp);
  PutFlat("", flat, &data);
  WriteCalibration(path, data);
}

FlatField ReadFlatField(const std::filesystem::path& path, CalibrationDemand demand) {
  Product product(path, "flat-field", std::move(demand));
  FlatField flat = TakeFlat("", &product);
  product.Finish();
  return flat;
}

void WriteColourFlats(const std::filesystem::path& path, const CalibrationStamp& stamp,
                      const ColourFlats& flats) {
  CalibrationData data = StampedWithLight("flat-field", stamp);
  for (std::size_t c = 0; c < kChannels; ++c) PutFlat(ColourPrefix(c), flats[c], &data);
  WriteCalibration(path, data);
}

ColourFlats ReadColourFlats(const std::filesystem::path& path, CalibrationDemand demand) {
  Product product(path, "flat-field", std::move(demand));
  ColourFlats flats;
  for (std::size_t c = 0; c < kChannels; ++c) flats[c] = TakeFlat(ColourPrefix(c), &product);
  product.Finish();
  return flats;
}

void WriteResponsivity(const std::filesystem::path& path, const CalibrationStamp& stamp,
                       const Responsivity& responsivity) {
  CalibrationData data = StampedWithLight("responsivity", stamp);
  data.texts["standard"] = responsivity.standard;
  for (std::size_t c = 0; c < kChannels; ++c) {
    data.estimates[fmt::format("{}_e_sr_per_s", kChannelNames[c])] = responsivity.responsivity[c];
  }
  WriteCalibration(path, data);
}

Responsivity ReadResponsivity(const std::filesystem::path& path, CalibrationDemand demand) {
  Product product(path, "responsivity", std::move(demand));
  Responsivity responsivity;
  responsivity.standard = product.Text("standard");
  for (std::size_t c = 0; c < kChannels; ++c) {
    const std::string name = fmt::format("{}_e_sr_per_s", kChannelNames[c]);
    responsivity.responsivity[c] = product.Number(name);
    if (!(responsivity.responsivity[c].value > 0)) product.Fail(name + ": must be > 0");
  }
  product.Finish();
  return responsivity;
}

void WriteStrayLight(const std::filesystem::path& path, const CalibrationStamp& stamp,
                     const StrayLights& stray) {
  CalibrationData data = StampedWithLight("stray-light", stamp);
  for (std::size_t c = 0; c < kChannels; ++c) {
    const std::string name = kChannelNames[c];
    data.estimates[name + "_background_e_per_s"] = stray[c].background;
    data.estimates[name + "_glare"] = stray[c].glare;
  }
  WriteCalibration(path, data);
}

StrayLights ReadStrayLight(const std::filesystem::path& path, CalibrationDemand demand) {
  Product product(path, "stray-light", std::move(demand));
  StrayLights stray;
  for (std::size_t c = 0; c < kChannels; ++c) {
    const std::string name = kChannelNames[c];
    stray[c].background = product.Number(name + "_background_e_per_s");
    stray[c].glare = product.Number(name + "_glare");
    if (!(stray[c].glare.value < 1)) product.Fail(name + "_glare: must be < 1");
  }
  product.Finish();
  return stray;
}

}  // namespace gonio
