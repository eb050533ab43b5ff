// SPDX-License-Identifier: Apache-2.0
// Finding cameras without driving them.
#include <gmock/gmock.h>

#include "drivers/genicam_list.h"
#include "tests/genicam/gige_rig.h"
#include "tests/genicam/own_network.h"

namespace gonio {
namespace {

using testing::HasSubstr;

TEST(GenicamList, AskedACameraSaysWhatItIsAndWhoHasIt) {
  GigeRig rig;
  ASSERT_TRUE(rig.camera.ok()) << rig.camera.error().message;
  const auto taken = AskGigeCamera("127.0.0.1");
  ASSERT_TRUE(taken.ok()) << taken.error().message;
  EXPECT_EQ(taken->vendor, "Goniopilot");
  EXPECT_EQ(taken->model, "GigE double");
  EXPECT_EQ(taken->serial, "GP0001");
  EXPECT_EQ(taken->address, "127.0.0.1");
  EXPECT_TRUE(taken->taken);
  // The one that has it keeps it.
  EXPECT_TRUE(rig.driver().Capture(Seconds(0.001), {}).ok());
}

// Example failure is a camera that stays in the hands of who only asked.
TEST(GenicamList, AnAskedCameraIsFreeAgain) {
  const auto device = ServeDouble();
  for (int i = 0; i < 2; ++i) {
    const auto free = AskGigeCamera("127.0.0.1");
    ASSERT_TRUE(free.ok()) << free.error().message;
    EXPECT_FALSE(free->taken);
  }
  SystemClock clock;
  EXPECT_TRUE(GenicamCamera::Open(DriverSettings(), clock).ok());
}

TEST(GenicamList, NoCameraIsRefused) {
  const auto nobody = AskGigeCamera("127.0.0.1");
  ASSERT_FALSE(nobody.ok());
  EXPECT_EQ(nobody.error().code, ErrorCode::kRefused);
  EXPECT_THAT(nobody.error().message, HasSubstr("no camera at 127.0.0.1"));
  EXPECT_THAT(AskGigeCamera("camera.lab").error().message, HasSubstr("no IPv4 address"));
}

// Example failure is a list of USB cameras that searches the network for others, or leaves no
// search possible afterwards.
TEST(GenicamList, OnlyASearchFindsCamerasOnTheNetwork) {
  if (!in_own_network) GTEST_SKIP() << "a search would go out on the network";
  const auto device = ServeDouble();
  for (int i = 0; i < 2; ++i) {
    for (const GenicamCameraInfo& camera : ListUsbCameras()) {
      EXPECT_EQ(camera.protocol, "USB3Vision");
    }
    const auto found = SearchGigeCameras();
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].protocol, "GigEVision");
    EXPECT_EQ(found[0].serial, "GP0001");
    EXPECT_EQ(found[0].address, "127.0.0.1");
    EXPECT_FALSE(found[0].id.empty());
  }
}

}  // namespace
}  // namespace gonio
