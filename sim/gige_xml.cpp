// SPDX-License-Identifier: Apache-2.0
#include "sim/gige_xml.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "sim/gige_packing.h"

namespace gonio {
namespace {

using R = GigeRegisters;
constexpr const char* kReadWrite = "RW";
constexpr const char* kReadOnly = "RO";

std::string Category(const std::string& name, const std::vector<std::string>& features) {
  std::string text = fmt::format("<Category Name=\"{}\" NameSpace=\"Standard\">\n", name);
  for (const std::string& feature : features) {
    text += fmt::format("  <pFeature>{}</pFeature>\n", feature);
  }
  return text + "</Category>\n";
}

std::string Place(std::uint32_t address, int length, const char* access) {
  return fmt::format(
      "  <Address>0x{:X}</Address>\n  <Length>{}</Length>\n  <AccessMode>{}</AccessMode>\n"
      "  <pPort>Device</pPort>\n  <Cachable>NoCache</Cachable>\n",
      address, length, access);
}

std::string Text(const std::string& name, std::uint32_t address, int length) {
  return fmt::format("<StringReg Name=\"{}\" NameSpace=\"Standard\">\n{}</StringReg>\n", name,
                     Place(address, length, kReadOnly));
}

// Of 32 bits, for a feature of the same name to stand on.
std::string Register(const std::string& name, std::uint32_t address, const char* access) {
  return fmt::format(
      "<IntReg Name=\"{}Register\" NameSpace=\"Custom\">\n{}"
      "  <Sign>Unsigned</Sign>\n  <Endianess>BigEndian</Endianess>\n</IntReg>\n",
      name, Place(address, 4, access));
}

// Maximum is a number or the name of another feature.
std::string Integer(const std::string& name, std::uint32_t address, int min, const std::string& max,
                    int step, const char* access = kReadWrite) {
  const bool named = max.find_first_not_of("0123456789") != std::string::npos;
  return fmt::format(
             "<Integer Name=\"{}\" NameSpace=\"Standard\">\n  <pValue>{}Register</pValue>\n"
             "  <Min>{}</Min>\n  <{}>{}</{}>\n  <Inc>{}</Inc>\n</Integer>\n",
             name, name, min, named ? "pMax" : "Max", max, named ? "pMax" : "Max", step) +
         Register(name, address, access);
}

std::string Enumeration(const std::string& name, std::uint32_t address,
                        const std::vector<std::pair<std::string, std::uint32_t>>& entries) {
  std::string text = fmt::format("<Enumeration Name=\"{}\" NameSpace=\"Standard\">\n", name);
  for (const auto& [entry, value] : entries) {
    text += fmt::format(
        "  <EnumEntry Name=\"{}\" NameSpace=\"Standard\">\n    <Value>{}</Value>\n"
        "  </EnumEntry>\n",
        entry, value);
  }
  return text + fmt::format("  <pValue>{}Register</pValue>\n</Enumeration>\n", name) +
         Register(name, address, kReadWrite);
}

std::string Command(const std::string& name, const std::string& target, int value) {
  return fmt::format(
      "<Command Name=\"{}\" NameSpace=\"Standard\">\n  <pValue>{}Register</pValue>\n"
      "  <CommandValue>{}</CommandValue>\n</Command>\n",
      name, target, value);
}

// In steps of 1 / steps_per_unit.
std::string Float(const std::string& name, std::uint32_t address, const std::string& unit,
                  double min, double max, int steps_per_unit) {
  return fmt::format(
             "<Float Name=\"{0}\" NameSpace=\"Standard\">\n  <pValue>{0}Converter</pValue>\n"
             "  <Min>{1:.1f}</Min>\n  <Max>{2:.1f}</Max>\n  <Unit>{3}</Unit>\n</Float>\n"
             "<Converter Name=\"{0}Converter\" NameSpace=\"Custom\">\n"
             "  <FormulaTo>FROM * {4} + 0.5</FormulaTo>\n"
             "  <FormulaFrom>TO / {4}.0</FormulaFrom>\n"
             "  <pValue>{0}Register</pValue>\n  <Slope>Increasing</Slope>\n</Converter>\n",
             name, min, max, unit, steps_per_unit) +
         Register(name, address, kReadWrite);
}

std::string Device(const GigeCameraSettings&) {
  return Category("DeviceControl",
                  {"DeviceVendorName", "DeviceModelName", "DeviceVersion", "DeviceFirmwareVersion",
                   "DeviceSerialNumber", "DeviceTemperature"}) +
         Text("DeviceVendorName", R::kVendor, 32) + Text("DeviceModelName", R::kModel, 32) +
         Text("DeviceVersion", R::kFirmware, 32) + Text("DeviceFirmwareVersion", R::kFirmware, 32) +
         Text("DeviceSerialNumber", R::kSerial, 16) +
         fmt::format(
             "<FloatReg Name=\"DeviceTemperature\" NameSpace=\"Standard\">\n{}"
             "  <Endianess>BigEndian</Endianess>\n  <Unit>C</Unit>\n</FloatReg>\n",
             Place(R::kTemperature, 4, kReadOnly));
}

std::string Image(const GigeCameraSettings& settings) {
  std::vector<std::pair<std::string, std::uint32_t>> formats;
  for (const GigeFormat& format : GigeFormats()) formats.emplace_back(format.name, format.code);
  const std::string width = std::to_string(settings.sensor_width);
  const std::string height = std::to_string(settings.sensor_height);
  return Category("ImageFormatControl", {"SensorWidth", "SensorHeight", "OffsetX", "OffsetY",
                                         "Width", "Height", "PixelFormat"}) +
         Integer("SensorWidth", R::kSensorWidth, 1, width, 1, kReadOnly) +
         Integer("SensorHeight", R::kSensorHeight, 1, height, 1, kReadOnly) +
         Integer("OffsetX", R::kOffsetX, 0, width, 4) +
         Integer("OffsetY", R::kOffsetY, 0, height, 2) +
         Integer("Width", R::kWidth, 4, "SensorWidth", 4) +
         Integer("Height", R::kHeight, 2, "SensorHeight", 2) +
         Enumeration("PixelFormat", R::kPixelFormat, formats);
}

std::string Acquisition(const GigeCameraSettings& settings) {
  return Category("AcquisitionControl",
                  {"AcquisitionMode", "AcquisitionStart", "AcquisitionStop", "TriggerSelector",
                   "TriggerMode", "TriggerSource", "TriggerActivation", "TriggerSoftware",
                   "ExposureTime", "ExposureAuto"}) +
         Enumeration("AcquisitionMode", R::kMode, {{"Continuous", 1}, {"SingleFrame", 2}}) +
         Register("Acquisition", R::kAcquisition, kReadWrite) +
         Command("AcquisitionStart", "Acquisition", 1) +
         Command("AcquisitionStop", "Acquisition", 0) +
         Enumeration("TriggerSelector", R::kTriggerSelector, {{"FrameStart", 0}}) +
         Enumeration("TriggerMode", R::kTriggerMode, {{"Off", 0}, {"On", 1}}) +
         Enumeration("TriggerSource", R::kTriggerSource, {{"Line0", 0}, {"Software", 1}}) +
         Enumeration("TriggerActivation", R::kTriggerActivation, {{"RisingEdge", 0}}) +
         Register("TriggerSoftware", R::kTriggerSoftware, kReadWrite) +
         Command("TriggerSoftware", "TriggerSoftware", 1) +
         Float("ExposureTime", R::kExposure, "us", settings.min_exposure_us,
               settings.max_exposure_us, 1) +
         Enumeration("ExposureAuto", R::kExposureAuto, {{"Off", 0}, {"Continuous", 1}});
}

std::string Analog(const GigeCameraSettings& settings) {
  return Category("AnalogControl", {"Gain", "GainAuto", "BlackLevel"}) +
         Float("Gain", R::kGain, "dB", 0, settings.max_gain_db, 10) +
         Enumeration("GainAuto", R::kGainAuto, {{"Off", 0}, {"Continuous", 1}}) +
         Float("BlackLevel", R::kBlackLevel, "DN", 0, settings.max_black_level, 1);
}

std::string Boolean(const std::string& name) {
  return fmt::format(
      "<Boolean Name=\"{0}\" NameSpace=\"Standard\">\n  <pValue>{0}Register</pValue>\n"
      "  <OnValue>1</OnValue>\n  <OffValue>0</OffValue>\n</Boolean>\n",
      name);
}

// What a frame says about itself: a number behind its pixels.
std::string Chunk(const std::string& name, std::uint32_t id, const std::string& unit) {
  return fmt::format(
      "<Port Name=\"{0}Port\" NameSpace=\"Custom\">\n  <ChunkID>{1:X}</ChunkID>\n</Port>\n"
      "<FloatReg Name=\"{0}\" NameSpace=\"Standard\">\n  <Address>0x0</Address>\n"
      "  <Length>{2}</Length>\n  <AccessMode>RO</AccessMode>\n  <pPort>{0}Port</pPort>\n"
      "  <Endianess>BigEndian</Endianess>\n  <Unit>{3}</Unit>\n</FloatReg>\n",
      name, id, GigeChunks::kBytes, unit);
}

std::string ChunkData() {
  return Category("ChunkDataControl", {"ChunkModeActive", "ChunkSelector", "ChunkEnable",
                                       "ChunkExposureTime", "ChunkGain"}) +
         Boolean("ChunkModeActive") + Register("ChunkModeActive", R::kChunkMode, kReadWrite) +
         Enumeration("ChunkSelector", R::kChunkSelector, {{"ExposureTime", 0}, {"Gain", 1}}) +
         Boolean("ChunkEnable") +
         fmt::format(
             "<IntReg Name=\"ChunkEnableRegister\" NameSpace=\"Custom\">\n{}"
             "  <pIndex Offset=\"4\">ChunkSelectorRegister</pIndex>\n"
             "  <Sign>Unsigned</Sign>\n  <Endianess>BigEndian</Endianess>\n</IntReg>\n",
             Place(R::kChunkEnable, 4, kReadWrite)) +
         Register("ChunkExposureTimeEnable", R::kChunkEnable, kReadOnly) +
         Register("ChunkGainEnable", R::kChunkEnable + 4, kReadOnly) +
         Chunk("ChunkExposureTime", GigeChunks::kExposure, "us") +
         Chunk("ChunkGain", GigeChunks::kGain, "dB");
}

std::string Transport(const GigeCameraSettings& settings) {
  const std::string image = "W * H * ((F &gt;&gt; 16) &amp; 255) / 8";
  const auto variable = [](const char* letter, const char* feature) {
    return fmt::format("  <pVariable Name=\"{}\">{}</pVariable>\n", letter, feature);
  };
  const std::string chunks =
      variable("C", "ChunkModeActiveRegister") + variable("E", "ChunkExposureTimeEnableRegister") +
      variable("G", "ChunkGainEnableRegister") +
      fmt::format("  <Formula>{} + C * ({} + (E + G) * {})</Formula>\n", image,
                  GigeChunks::kEndBytes, GigeChunks::kBytes + GigeChunks::kEndBytes);
  return Category("TransportLayerControl", {"PayloadSize"}) +
         "<IntSwissKnife Name=\"PayloadSize\" NameSpace=\"Standard\">\n" + variable("W", "Width") +
         variable("H", "Height") + variable("F", "PixelFormatRegister") +
         (settings.chunks ? chunks : fmt::format("  <Formula>{}</Formula>\n", image)) +
         "</IntSwissKnife>\n"
         "<Integer Name=\"TLParamsLocked\">\n  <Visibility>Invisible</Visibility>\n"
         "  <Value>0</Value>\n  <Min>0</Min>\n  <Max>1</Max>\n</Integer>\n";
}

}  // namespace

std::string GigeDescription(const GigeCameraSettings& settings) {
  std::vector<std::string> categories = {"DeviceControl", "ImageFormatControl",
                                         "AcquisitionControl", "AnalogControl",
                                         "TransportLayerControl"};
  if (settings.chunks) categories.push_back("ChunkDataControl");
  return fmt::format(
             "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n"
             "<RegisterDescription ModelName=\"{}\" VendorName=\"{}\" StandardNameSpace=\"None\"\n"
             "    SchemaMajorVersion=\"1\" SchemaMinorVersion=\"1\" SchemaSubMinorVersion=\"0\"\n"
             "    MajorVersion=\"1\" MinorVersion=\"0\" SubMinorVersion=\"0\" ToolTip=\"\"\n"
             "    ProductGuid=\"0\" VersionGuid=\"0\"\n"
             "    xmlns=\"http://www.genicam.org/GenApi/Version_1_1\">\n",
             settings.model, settings.vendor) +
         Category("Root", categories) + Device(settings) + Image(settings) + Acquisition(settings) +
         Analog(settings) + Transport(settings) + (settings.chunks ? ChunkData() : "") +
         "<Port Name=\"Device\" NameSpace=\"Standard\"></Port>\n</RegisterDescription>\n";
}

}  // namespace gonio
