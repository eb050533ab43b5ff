// SPDX-License-Identifier: Apache-2.0
#include "acquisition/radiometry/calibration_file.h"

#include <gmock/gmock.h>

#include <functional>
#include <limits>

#include "acquisition/radiometry/calibration_products.h"
#include "core/error.h"
#include "core/file.h"
#include "tests/core/temp_dir.h"
#include "tests/radiometry/synthetic_sensor.h"

namespace gonio {
namespace {

using testing::HasSubstr;

constexpr std::int64_t kDay = 86400;
constexpr std::int64_t kCreated = 1714727564;  // 2024-05-03T09:12:44Z

SensorFormat Format(PixelLayout layout = PixelLayout::kRgb) {
  return {
      .camera = "Maker \"X\" 7", .left = 8, .top = 4, .width = 6, .height = 4, .layout = layout};
}

CalibrationStamp Stamp() { return {kCreated, Format(), 41.5}; }

CalibrationDemand Demand() {
  CalibrationDemand demand;
  demand.format = Format();
  demand.now = kCreated + kDay;
  demand.max_age = 30.0 * kDay;
  return demand;
}

SiteImage RandomImage(const SensorFormat& format, std::uint64_t seed) {
  Random random(seed, 0);
  SiteImage image(format.sites());
  for (float& v : image) v = static_cast<float>(random.Normal());
  return image;
}

FlatField Flat(PixelLayout layout = PixelLayout::kRgb) {
  FlatField flat{.format = Format(layout), .response = {}, .sigma = {}};
  flat.response = RandomImage(flat.format, 1);
  flat.sigma.assign(flat.format.sites(), 0.01F);
  flat.sigma[3] = std::numeric_limits<float>::infinity();
  return flat;
}

std::string Replaced(const std::string& text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.substr(0, at) + to + text.substr(at + from.size());
}

TEST(CalibrationFile, KeepsImagesBitForBit) {
  const TempDir dir;
  for (const PixelLayout layout : {PixelLayout::kMono, PixelLayout::kRgb, PixelLayout::kBayerGb}) {
    const FlatField flat = Flat(layout);
    WriteFlatField(dir / "flat.yaml", {kCreated, flat.format, std::nullopt}, flat);
    CalibrationDemand demand = Demand();
    demand.format = flat.format;
    const FlatField read = ReadFlatField(dir / "flat.yaml", demand);
    EXPECT_EQ(read.response, flat.response);
    EXPECT_EQ(read.sigma, flat.sigma);
    EXPECT_EQ(read.format, flat.format);
  }
}

TEST(CalibrationFile, KeepsADarkLibrary) {
  const TempDir dir;
  SyntheticSensor sensor;
  sensor.format = Format();
  Random random(1, 1);
  std::vector<Frame> frames;
  for (const double temperature : {20.0, 30.0}) {
    for (const double t : {0.1, 0.1, 0.7, 0.7}) {
      frames.push_back(sensor.Expose({0, 0, 0}, t, 1, &random));
      frames.back().temperature_c = temperature;
    }
  }
  const auto library = MeasureDark(sensor.format, frames, 2, kCreated);
  ASSERT_TRUE(library.ok()) << library.error().message;
  WriteDark(dir / "dark.yaml", *library);
  const DarkLibrary read = ReadDark(dir / "dark.yaml", Demand());
  ASSERT_EQ(read.fits.size(), 2u);
  const auto before = DarkFor(*library, sensor.format, 0.5, 29, kCreated);
  const auto after = DarkFor(read, sensor.format, 0.5, 29, kCreated);
  ASSERT_TRUE(before.ok() && after.ok());
  EXPECT_EQ(after->counts, before->counts);
  EXPECT_EQ(after->variance, before->variance);
  EXPECT_EQ(read.fits[1].noise, library->fits[1].noise);
}

TEST(CalibrationFile, KeepsTheOtherProducts) {
  const TempDir dir;
  SensorCalibration sensor{.gain = {2.01, 0.02},
                           .read_noise = {5.5, 0.1},
                           .full_well = {1e4, 50},
                           .exposure_offset = {2.5e-5, 1e-6}};
  sensor.linearity = *Linearity::FromKnots({{100, {1.001, 1e-3}}, {3000, {1.0301, 2e-3}}});
  WriteSensor(dir / "sensor.yaml", Stamp(), sensor);
  const SensorCalibration read = ReadSensor(dir / "sensor.yaml", Demand());
  EXPECT_EQ(read.gain.value, 2.01);
  EXPECT_EQ(read.read_noise.sigma, 0.1);
  EXPECT_EQ(read.exposure_offset.value, 2.5e-5);
  EXPECT_EQ(read.exposure_offset.sigma, 1e-6);
  EXPECT_EQ(read.linearity.Correct(1500), sensor.linearity.Correct(1500));

  BadPixels bad;
  bad.mask.assign(Format().sites(), 0);
  bad.mask[5] = kHotPixel | kDeadPixel;
  WriteBadPixels(dir / "bad.yaml", Stamp(), bad);
  EXPECT_EQ(ReadBadPixels(dir / "bad.yaml", Demand()).mask, bad.mask);
  EXPECT_EQ(ReadBadPixels(dir / "bad.yaml", Demand()).dead, 1u);

  const Responsivity r{"tile \\ 17", {{{1e4, 100}, {2e4, 150}, {3e4, 200}}}};
  WriteResponsivity(dir / "r.yaml", Stamp(), r);
  EXPECT_EQ(ReadResponsivity(dir / "r.yaml", Demand()).standard, r.standard);
  EXPECT_EQ(ReadResponsivity(dir / "r.yaml", Demand()).responsivity[2].sigma, 200);

  StrayLights stray;
  stray[1] = {.background = {12, 0.5}, .glare = {0.01, 0.002}};
  WriteStrayLight(dir / "s.yaml", Stamp(), stray);
  EXPECT_EQ(ReadStrayLight(dir / "s.yaml", Demand())[1].glare.value, 0.01);
}

TEST(CalibrationFile, IsRefusedForAnotherCameraOrTime) {
  const TempDir dir;
  WriteFlatField(dir / "flat.yaml", Stamp(), Flat());
  const auto complaint = [&](const std::function<void(CalibrationDemand*)>& change) {
    CalibrationDemand demand = Demand();
    change(&demand);
    return MessageOf<ConfigError>([&] { ReadFlatField(dir / "flat.yaml", demand); });
  };
  using D = CalibrationDemand;
  EXPECT_THAT(complaint([](D* d) { d->format.camera = "Y"; }), HasSubstr("flat.yaml: camera is Y"));
  EXPECT_THAT(complaint([](D* d) { d->format.left = 0; }), HasSubstr("left is 0"));
  EXPECT_THAT(complaint([](D* d) { d->format.height = 5; }), HasSubstr("height is 5"));
  EXPECT_THAT(complaint([](D* d) { d->format.layout = PixelLayout::kMono; }), HasSubstr("layout"));
  EXPECT_THAT(complaint([](D* d) { d->format.gain_db = 1; }), HasSubstr("gain in dB is 1"));
  EXPECT_THAT(complaint([](D* d) { d->format.full_scale = 255; }), HasSubstr("full scale is 255"));
  EXPECT_THAT(complaint([](D* d) { d->now = kCreated - 1; }), HasSubstr("created_utc: is in the"));
  EXPECT_THAT(complaint([](D* d) { d->now = kCreated + 45 * kDay; }),
              HasSubstr("is 45.0 days ago, the limit is 30.0"));
  EXPECT_THAT(complaint([](D* d) {
                d->temperature_c = 30;
                d->max_temperature_difference = 5;
              }),
              HasSubstr("temperature_c: is 11.5 degrees"));
  const std::string kind =
      MessageOf<ConfigError>([&] { ReadBadPixels(dir / "flat.yaml", Demand()); });
  EXPECT_THAT(kind, HasSubstr("flat.yaml:3: kind"));
}

TEST(CalibrationFile, IsRefusedWhenItIsBroken) {
  const TempDir dir;
  WriteFlatField(dir / "flat.yaml", Stamp(), Flat());
  const std::string text = ReadTextFile(dir / "flat.yaml");
  const auto complaint = [&](const std::string& changed) {
    return MessageOf<ConfigError>(
        [&] { ReadFlatField(dir.File("broken.yaml", changed), Demand()); });
  };
  EXPECT_THAT(complaint(Replaced(text, "version: 1", "version: 2")), HasSubstr(":2: version"));
  EXPECT_THAT(complaint(Replaced(text, "format: gonio-c", "format: c")), HasSubstr(":1: format"));
  EXPECT_THAT(complaint(Replaced(text, "2024-05-03T", "2024-05-33T")), HasSubstr("created_utc"));
  EXPECT_THAT(complaint(Replaced(text, "response:", "answer:")), HasSubstr("response: is missing"));
  EXPECT_THAT(complaint(text + "more: 1\n"), HasSubstr("more"));
  EXPECT_THAT(complaint(Replaced(text, "file: \"", "file: \"../")), HasSubstr("beside"));
  EXPECT_THAT(complaint(Replaced(text, "file: \"flat", "file: \"gone")), HasSubstr("cannot read"));
}

TEST(CalibrationFile, IsRefusedWithAChangedImage) {
  const TempDir dir;
  WriteFlatField(dir / "flat.yaml", Stamp(), Flat());
  for (const auto& entry : std::filesystem::directory_iterator(dir.path())) {
    if (entry.path().extension() != ".tiff") continue;
    std::string bytes = ReadTextFile(entry.path());
    bytes[bytes.size() / 2] ^= 1;
    dir.File(entry.path().filename().string(), bytes);
  }
  const std::string message =
      MessageOf<ConfigError>([&] { ReadFlatField(dir / "flat.yaml", Demand()); });
  EXPECT_THAT(message, HasSubstr(".tiff: was changed since "));
}

// The images of the new one have other names, so the old one stays whole until its YAML is
// replaced.
TEST(CalibrationFile, LeavesThePreviousOneWholeUntilTheEnd) {
  const TempDir dir;
  const FlatField old = Flat();
  WriteFlatField(dir / "flat.yaml", Stamp(), old);
  const std::string text = ReadTextFile(dir / "flat.yaml");
  FlatField next = old;
  next.response[0] = 7;
  WriteFlatField(dir / "flat.yaml", Stamp(), next);
  EXPECT_EQ(ReadFlatField(dir / "flat.yaml", Demand()).response, next.response);
  dir.File("flat.yaml", text);
  EXPECT_EQ(ReadFlatField(dir / "flat.yaml", Demand()).response, old.response);
  EXPECT_THROW(WriteFlatField(dir / "none" / "flat.yaml", Stamp(), old), std::runtime_error);
}

}  // namespace
}  // namespace gonio
