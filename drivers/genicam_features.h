// SPDX-License-Identifier: Apache-2.0
// A camera's features by their names in GenICam's SFNC, whatever it keeps them in.

#pragma once

#include <initializer_list>
#include <string>
#include <string_view>

#include "core/error.h"

typedef struct _ArvDevice ArvDevice;
typedef struct _GError GError;

namespace gonio {

// What a feature may be set to.
struct FeatureBounds {
  double min = 0;
  double max = 0;
  double step = 0;  // 0: any value between them, or the camera does not say
};

// Every Set...() reads back what it wrote: a camera may round, and a few forget. The thread that
// owns the device. Errors: kRefused (no such feature, a value it does not take), kDisconnected (no
// answer: GigE cameras take Aravis 2.5 s for that; or we are no longer in control of it).
class GenicamFeatures {
 public:
  explicit GenicamFeatures(ArvDevice* device) : device_(device) {}  // must outlive it

  bool Has(const std::string& feature) const;
  // SFNC has renamed features: the first of `names` that the camera has, or the empty string.
  std::string FirstOf(std::initializer_list<const char*> names) const;

  // Of floats, integers and enumerations.
  Result<double> Number(const std::string& feature) const;
  Result<std::string> Text(const std::string& feature) const;
  Result<FeatureBounds> Bounds(const std::string& feature) const;

  // kRefused also if the camera uses a value further than `tolerance` from the one wanted.
  Result<void> SetNumber(const std::string& feature, double wanted, double tolerance = 0);
  Result<void> SetText(const std::string& feature, const std::string& wanted);
  // As SetText(), but for a feature that the camera may lack.
  Result<void> SetTextIfThere(const std::string& feature, const std::string& wanted);
  Result<void> Execute(const std::string& feature);

 private:
  Result<void> Write(const std::string& feature, double value);

  ArvDevice* const device_;
};

// Takes the error over, which may be nullptr, and says what was tried.
Error GenicamError(GError* error, const std::string& what);

}  // namespace gonio
