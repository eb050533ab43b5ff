// SPDX-License-Identifier: Apache-2.0
#include "drivers/genicam_features.h"

#include <arv.h>
#include <fmt/format.h>

#include <cmath>

namespace gonio {
namespace {

// It does not answer; or it answers, but obeys nobody or another, as after a loss of power.
bool Lost(const GError* error) {
  if (error->domain != ARV_DEVICE_ERROR) return false;
  switch (error->code) {
    case ARV_DEVICE_ERROR_TIMEOUT:
    case ARV_DEVICE_ERROR_NOT_CONNECTED:
    case ARV_DEVICE_ERROR_TRANSFER_ERROR:
    case ARV_DEVICE_ERROR_NOT_FOUND:
    case ARV_DEVICE_ERROR_NOT_CONTROLLER:
    case ARV_DEVICE_ERROR_PROTOCOL_ERROR_ACCESS_DENIED:
      return true;
    default:
      return false;
  }
}

Error Refused(std::string message) { return {ErrorCode::kRefused, std::move(message)}; }

}  // namespace

Error GenicamError(GError* error, const std::string& what) {
  if (!error) return {ErrorCode::kProtocol, what + ": failed without a reason"};
  const Error result{Lost(error) ? ErrorCode::kDisconnected : ErrorCode::kRefused,
                     fmt::format("{}: {}", what, error->message)};
  g_error_free(error);
  return result;
}

bool GenicamFeatures::Has(const std::string& feature) const {
  GError* error = nullptr;
  const bool has = arv_device_is_feature_available(device_, feature.c_str(), &error);
  g_clear_error(&error);
  return has;
}

std::string GenicamFeatures::FirstOf(std::initializer_list<const char*> names) const {
  for (const char* name : names) {
    if (Has(name)) return name;
  }
  return "";
}

Result<double> GenicamFeatures::Number(const std::string& feature) const {
  ArvGcNode* node = arv_device_get_feature(device_, feature.c_str());
  GError* error = nullptr;
  double value = 0;
  if (ARV_IS_GC_FLOAT(node)) {
    value = arv_gc_float_get_value(ARV_GC_FLOAT(node), &error);
  } else if (ARV_IS_GC_INTEGER(node)) {
    value = static_cast<double>(arv_gc_integer_get_value(ARV_GC_INTEGER(node), &error));
  } else {
    return Refused(feature + ": the camera has no number of this name");
  }
  if (error) return GenicamError(error, feature);
  return value;
}

Result<std::string> GenicamFeatures::Text(const std::string& feature) const {
  GError* error = nullptr;
  const char* text = arv_device_get_string_feature_value(device_, feature.c_str(), &error);
  if (error || !text) return GenicamError(error, feature);
  return std::string(text);
}

Result<FeatureBounds> GenicamFeatures::Bounds(const std::string& feature) const {
  ArvGcNode* node = arv_device_get_feature(device_, feature.c_str());
  FeatureBounds bounds;
  GError* error = nullptr;
  if (ARV_IS_GC_FLOAT(node)) {
    arv_device_get_float_feature_bounds(device_, feature.c_str(), &bounds.min, &bounds.max, &error);
    return error ? Result<FeatureBounds>(GenicamError(error, feature)) : bounds;
  }
  gint64 min = 0;
  gint64 max = 0;
  arv_device_get_integer_feature_bounds(device_, feature.c_str(), &min, &max, &error);
  if (error) return GenicamError(error, feature);
  const gint64 step = arv_device_get_integer_feature_increment(device_, feature.c_str(), &error);
  if (error) return GenicamError(error, feature);
  return FeatureBounds{static_cast<double>(min), static_cast<double>(max),
                       static_cast<double>(step)};
}

Result<void> GenicamFeatures::Write(const std::string& feature, double value) {
  ArvGcNode* node = arv_device_get_feature(device_, feature.c_str());
  GError* error = nullptr;
  if (ARV_IS_GC_FLOAT(node)) {
    arv_gc_float_set_value(ARV_GC_FLOAT(node), value, &error);
  } else if (ARV_IS_GC_INTEGER(node)) {
    arv_gc_integer_set_value(ARV_GC_INTEGER(node), std::llround(value), &error);
  } else {
    return Refused(feature + ": the camera has no number of this name");
  }
  if (error) return GenicamError(error, fmt::format("{} = {:.10g}", feature, value));
  return {};
}

Result<void> GenicamFeatures::SetNumber(const std::string& feature, double wanted,
                                        double tolerance) {
  if (!Has(feature)) return Refused(feature + ": the camera has no feature of this name");
  const auto bounds = Bounds(feature);
  if (!bounds) return bounds.error();
  // Also true of NaN.
  if (!(wanted >= bounds->min && wanted <= bounds->max)) {
    return Refused(fmt::format("{}: wanted {:.10g}, but the camera allows {:.10g} .. {:.10g}",
                               feature, wanted, bounds->min, bounds->max));
  }
  if (const auto written = Write(feature, wanted); !written) return written;
  const auto got = Number(feature);
  if (!got) return got.error();
  const bool on_step = bounds->step <= 1 || std::fmod(*got - bounds->min, bounds->step) == 0;
  if (std::abs(*got - wanted) <= tolerance && on_step) return {};
  const std::string steps =
      bounds->step > 1 ? fmt::format("; its steps are of {:.10g}", bounds->step) : "";
  return Refused(fmt::format("{}: wanted {:.10g}, got {:.10g}{}", feature, wanted, *got, steps));
}

Result<void> GenicamFeatures::SetText(const std::string& feature, const std::string& wanted) {
  GError* error = nullptr;
  arv_device_set_string_feature_value(device_, feature.c_str(), wanted.c_str(), &error);
  if (error) return GenicamError(error, fmt::format("{} = {}", feature, wanted));
  const auto got = Text(feature);
  if (!got) return got.error();
  if (*got == wanted) return {};
  return Refused(fmt::format("{}: wanted {}, got {}", feature, wanted, *got));
}

Result<void> GenicamFeatures::SetTextIfThere(const std::string& feature,
                                             const std::string& wanted) {
  return Has(feature) ? SetText(feature, wanted) : Result<void>();
}

Result<void> GenicamFeatures::Execute(const std::string& feature) {
  GError* error = nullptr;
  arv_device_execute_command(device_, feature.c_str(), &error);
  if (error) return GenicamError(error, feature);
  return {};
}

}  // namespace gonio
