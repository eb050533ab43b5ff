// SPDX-License-Identifier: Apache-2.0
// How the stages of a tilting sample orient it in the laboratory.

#pragma once

#include <Eigen/Core>

#include "acquisition/rig_kind.h"

namespace gonio {

// The laboratory's frame: x towards the light, which stands still, z up. With all axes at zero the
// sample faces the light: its normal (its own z) is the laboratory's x, its x lies along y, its y
// points up.
Eigen::Matrix3d SampleAtZero();

// Columns: the sample's axes in the laboratory, of a rig of kind kTiltingSample.
//
//   Rz(sample_turn) Ry(-sample_tilt) SampleAtZero() Rz(sample_azimuth)
//
// so that the normal is (cos tilt cos turn, cos tilt sin turn, sin tilt).
Eigen::Matrix3d LabFromSample(const AxisPositions& axes);

// By how much [rad] the camera, level in the laboratory, is turned about its line of sight, from
// right to down, against one on an arm that is level in the sample's frame (brdf/imaging.h).
double CameraRoll(const AxisPositions& axes);

}  // namespace gonio
