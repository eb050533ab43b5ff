// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "tests/conformance/camera.h"
#include "tests/genicam/gige_rig.h"

namespace gonio {
namespace {

// A camera whose double lives as long as it does.
class CameraOnItsDouble final : public Camera {
 public:
  CameraOnItsDouble() : rig_(std::make_unique<GigeRig>()) {}
  std::shared_ptr<Clock> clock() { return std::move(rig_->clock); }
  const std::string& name() const override { return rig_->camera.value()->name(); }
  const std::string& identity() const override { return rig_->camera.value()->identity(); }
  const CameraInfo& info() const override { return rig_->camera.value()->info(); }
  Result<Frame> Capture(Seconds exposure, std::stop_token stop) override {
    return rig_->driver().Capture(exposure, std::move(stop));
  }

 private:
  const std::unique_ptr<GigeRig> rig_;
};

CameraSubject MakeSubject() {
  auto camera = std::make_unique<CameraOnItsDouble>();
  auto clock = camera->clock();
  return {std::move(clock), std::move(camera)};
}

INSTANTIATE_TEST_SUITE_P(Genicam, CameraConformance, testing::Values(MakeSubject));

}  // namespace
}  // namespace gonio
