// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include "tests/genicam/own_network.h"

int main(int argc, char** argv) {
  gonio::EnterOwnNetwork();
  testing::InitGoogleMock(&argc, argv);
  return RUN_ALL_TESTS();
}
