// SPDX-License-Identifier: Apache-2.0
#include "sim/sim_optics.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "brdf/direction.h"
#include "core/check.h"
#include "core/units.h"

namespace gonio {
namespace {

using Eigen::Vector3d;

// A square is interpolated where its lattice errs by less than this of its brightest point if only
// its corners are known. Between the lattice's points the error is a quarter of that where the
// image is smooth, two thirds beside a silhouette, where normals turn as the square root of the
// distance.
constexpr float kTolerance = 5e-4F;
// Finer than this over a square [rad], half vectors are not asked whether a highlight hides there.
constexpr float kFinestHighlight = 2e-3F;

enum State : std::uint8_t { kUnasked = 0, kDark, kLit };

// The imaging as it truly is.
Imaging TrueImaging(Imaging imaging, const SimConfig& truth) {
  if (!imaging.resolves_directions()) return imaging;
  imaging.focal_length = truth.focal_length.value_or(imaging.focal_length);
  imaging.camera_distance = truth.camera_distance.value_or(imaging.camera_distance);
  imaging.light_distance = truth.light_distance.value_or(imaging.light_distance);
  imaging.principal_x = truth.principal_point[0];
  imaging.principal_y = truth.principal_point[1];
  imaging.camera_turn = truth.camera_turn;
  imaging.radial_distortion = truth.radial_distortion;
  return imaging;
}

// How far from the axis [focal lengths] a ray left the lens that a pixel receives at `distorted`.
double Straightened(double distorted, double distortion) {
  double r = distorted;
  for (int i = 0; i < 8; ++i) {  // Newton
    r -= (r * (1 + distortion * r * r) - distorted) / (1 + 3 * distortion * r * r);
  }
  return r;
}

}  // namespace

// The geometry of one pose of the arms.
class SimOptics::Pose {
 public:
  Pose(const SimOptics& optics, const SimArms& arms)
      : imaging_(optics.imaging_),
        sample_radius_(optics.truth_.sample_radius),
        middle_x_(optics.sensor_width_ / 2.0),
        middle_y_(optics.sensor_height_ / 2.0),
        target_(optics.truth_.target),
        placement_(Place(optics.truth_.rig, arms)),
        camera_(placement_.camera),
        turned_(SimTarget::Turned(imaging_.camera_turn)),
        pinhole_(imaging_.camera_distance * camera_.outward) {
    const SimMount& light = placement_.light;
    const auto& offset = optics.truth_.light_offset;
    light_at_infinity_ = std::isinf(imaging_.light_distance);
    light_ = light_at_infinity_ ? light.outward
                                : Vector3d((imaging_.light_distance + offset[2]) * light.outward +
                                           offset[0] * light.right + offset[1] * light.down);
  }

  // Of length focal_length along the optical axis.
  Vector3d Ray(double x, double y) const {
    Eigen::Vector2d at(x + 0.5 - middle_x_ - imaging_.principal_x,
                       y + 0.5 - middle_y_ - imaging_.principal_y);
    if (imaging_.radial_distortion != 0 && !at.isZero()) {
      const double r = at.norm() / imaging_.focal_length;
      at *= Straightened(r, imaging_.radial_distortion) / r;
    }
    const Vector3d own = turned_ * Vector3d(at.x(), at.y(), imaging_.focal_length);
    return own.x() * camera_.right + own.y() * camera_.down - own.z() * camera_.outward;
  }

  std::optional<SurfaceView> See(const Vector3d& ray) const {
    SurfaceView view;
    if (!Hit(ray, view)) return std::nullopt;
    view.tangent = Vector3d::UnitX() - view.normal.x() * view.normal;
    const double length = view.tangent.norm();
    if (length > 1e-9) {
      view.tangent /= length;
    } else {
      view.tangent = Vector3d(0, 0, -std::copysign(1.0, view.normal.x()));
    }
    const Vector3d second = view.normal.cross(view.tangent);
    const auto local = [&](const Vector3d& v) {
      return Vector3d(view.tangent.dot(v), second.dot(v), view.normal.dot(v));
    };
    view.local.wo = local((pinhole_ - view.point).normalized());
    if (light_at_infinity_) {
      view.local.wi = local(light_);
    } else {
      const Vector3d to_light = light_ - view.point;
      const double distance = to_light.norm();
      view.local.wi = local(to_light / distance);
      view.inverse_square = std::pow(imaging_.light_distance / distance, 2);
    }
    return view;
  }

  // What the ray's point on the target's plane is in the target's own frame.
  Vector3d OnTarget(const Vector3d& ray) const {
    const Vector3d from = target_.Into(pinhole_);
    const Vector3d way = target_.Into(pinhole_ + ray) - from;
    return from - from.z() / way.z() * way;
  }

 private:
  bool HitTarget(const Vector3d& ray, SurfaceView& view) const {
    view.normal = target_.Normal();
    if (!(view.normal.dot(ray) < 0)) return false;
    view.point = target_.OutOf(OnTarget(ray));
    return true;
  }

  // The first point on the way, if any.
  bool Hit(const Vector3d& ray, SurfaceView& view) const {
    if (target_.kind != SimTarget::Kind::kNone) return HitTarget(ray, view);
    const SampleShape& shape = imaging_.shape;
    if (shape.kind == SampleShape::Kind::kFlat) {
      if (!(pinhole_.z() > 0 && ray.z() < 0)) return false;
      view.point = pinhole_ - pinhole_.z() / ray.z() * ray;
      view.point.z() = 0;
      view.normal = Vector3d::UnitZ();
      return sample_radius_ <= 0 || view.point.norm() <= sample_radius_;
    }
    // A cylinder is a sphere to those who do not see x.
    const bool cylinder = shape.kind == SampleShape::Kind::kCylinder;
    const Vector3d seen(cylinder ? 0 : 1, 1, 1);
    const Vector3d centre(0, 0, -shape.radius);
    const Vector3d from = (pinhole_ - centre).cwiseProduct(seen);
    const Vector3d way = ray.cwiseProduct(seen);
    // |from + t way| = radius.
    const double a = way.squaredNorm();
    const double b = from.dot(way);
    const double discriminant = b * b - a * (from.squaredNorm() - shape.radius * shape.radius);
    if (!(discriminant >= 0) || b >= 0) return false;
    const double t = (-b - std::sqrt(discriminant)) / a;
    if (t <= 0) return false;
    view.point = pinhole_ + t * ray;
    view.normal = (view.point - centre).cwiseProduct(seen) / shape.radius;
    return !cylinder || sample_radius_ <= 0 || std::abs(view.point.x()) <= sample_radius_;
  }

  const Imaging& imaging_;
  const double sample_radius_;
  const double middle_x_;
  const double middle_y_;
  const SimTarget& target_;
  const SimPlacement placement_;
  const SimMount& camera_;
  const Eigen::Matrix3d turned_;  // the camera on its arm: right, down, forward
  const Vector3d pinhole_;
  bool light_at_infinity_ = false;
  Vector3d light_;  // where it is, or the direction to it
};

// Fills the planes of one region: squares of squares, in the order in which nobody reads a pixel
// that was interpolated.
class SimOptics::Renderer {
 public:
  Renderer(SimOptics& optics, const SimArms& arms, const Rgb& light, const Brdf& sample,
           const SimRegion& region, bool mono)
      : optics_(optics),
        pose_(optics, arms),
        sample_(sample),
        region_(region),
        planes_(mono ? 1 : kChannels),
        scale_(optics.truth_.responsivity * light),
        nodes_(optics.nodes_),
        states_(optics.states_) {
    const int square = optics.every_px_;
    // One more than a multiple of the squares: corners may lie outside.
    stride_ = (region.width + square - 1) / square * square + 1;
    const int rows = (region.height + square - 1) / square * square + 1;
    nodes_.resize(static_cast<std::size_t>(stride_) * rows);
    states_.assign(nodes_.size(), kUnasked);
  }

  std::vector<float> Run() {
    out_.assign(static_cast<std::size_t>(region_.width) * region_.height * planes_, 0);
    const int square = optics_.every_px_;
    for (int y = 0; y < region_.height; y += square) {
      for (int x = 0; x < region_.width; x += square) Fill(x, y, square);
    }
    return std::move(out_);
  }

 private:
  using Lattice = std::array<std::array<const Node*, 3>, 3>;

  std::size_t Index(int x, int y) const { return static_cast<std::size_t>(y) * stride_ + x; }

  const Node& At(int x, int y) {
    const std::size_t i = Index(x, y);
    if (states_[i] == kUnasked) states_[i] = Evaluate(x, y, nodes_[i]) ? kLit : kDark;
    return nodes_[i];
  }

  // False: dark.
  bool Evaluate(int x, int y, Node& node) const {
    node = {};
    const Vector3d ray = pose_.Ray(region_.x + x, region_.y + y);
    const auto view = pose_.See(ray);
    if (!view || !view->local.above_horizon()) return false;
    const auto f_r = Reflectance(x, y, *view);
    if (!f_r) return false;
    const double cos2 = std::pow(optics_.imaging_.focal_length, 2) / ray.squaredNorm();
    const double vignette = 1 - optics_.truth_.vignetting * (1 - cos2 * cos2);
    const Rgb rate =
        scale_ * f_r->max(0) * (view->local.cos_theta_i() * view->inverse_square * vignette);
    for (int c = 0; c < planes_; ++c) {
      node.rate[c] = static_cast<float>(planes_ == 1 ? rate.mean() : rate[c]);
    }
    const Vector3d half = (view->local.wi + view->local.wo).normalized();
    node.half_x = static_cast<float>(half.x());
    node.half_y = static_cast<float>(half.y());
    return true;
  }

  std::optional<Rgb> Reflectance(int x, int y, const SurfaceView& view) const {
    const SimTarget& target = optics_.truth_.target;
    if (target.kind == SimTarget::Kind::kNone) return sample_.Eval(view.local);
    if (target.kind == SimTarget::Kind::kMirror) return target.Mirror(view.local);
    return target.Paint([&](double dx, double dy) {
      return pose_.OnTarget(pose_.Ray(region_.x + x + dx, region_.y + y + dy));
    });
  }

  void Fill(int x, int y, int size) {
    if (x >= region_.width || y >= region_.height) return;
    if (size == 1) return Write(x, y, At(x, y));
    const int half = size / 2;
    Lattice lattice{};
    int lit = 0;
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 3; ++i) {
        lattice[j][i] = &At(x + i * half, y + j * half);
        if (states_[Index(x + i * half, y + j * half)] == kLit) ++lit;
      }
    }
    if (lit == 0) return;
    const bool smooth = lit == 9 && !MayHideHighlight(lattice) && IsSmooth(lattice);
    for (int j = 0; j < 2; ++j) {
      for (int i = 0; i < 2; ++i) {
        if (smooth) {
          Interpolate(x + i * half, y + j * half, half, *lattice[j][i], *lattice[j][i + 1],
                      *lattice[j + 1][i], *lattice[j + 1][i + 1]);
        } else {
          Fill(x + i * half, y + j * half, half);
        }
      }
    }
  }

  // Where the half vector is the normal a mirror peaks, however narrowly.
  static bool MayHideHighlight(const Lattice& lattice) {
    const auto distance = [&](const Node& a, const Node& b) {
      return std::hypot(a.half_x - b.half_x, a.half_y - b.half_y);
    };
    const float spread = std::max(distance(*lattice[0][0], *lattice[2][2]),
                                  distance(*lattice[0][2], *lattice[2][0]));
    if (spread < kFinestHighlight) return false;
    float nearest = spread;
    for (const auto& row : lattice) {
      for (const Node* node : row) nearest = std::min(nearest, distance(*node, Node{}));
    }
    return nearest < spread;
  }

  bool IsSmooth(const Lattice& lattice) const {
    for (int c = 0; c < planes_; ++c) {
      const auto at = [&](int i, int j) { return lattice[j][i]->rate[c]; };
      float brightest = 0;
      for (int i = 0; i < 9; ++i) brightest = std::max(brightest, at(i % 3, i / 3));
      const float allowed = kTolerance * brightest;
      for (int k = 0; k < 3; k += 2) {
        if (std::abs(at(1, k) - (at(0, k) + at(2, k)) / 2) > allowed) return false;
        if (std::abs(at(k, 1) - (at(k, 0) + at(k, 2)) / 2) > allowed) return false;
      }
      const float middle = (at(0, 0) + at(2, 0) + at(0, 2) + at(2, 2)) / 4;
      if (std::abs(at(1, 1) - middle) > allowed) return false;
    }
    return true;
  }

  void Write(int x, int y, const Node& node) {
    for (int c = 0; c < planes_; ++c) *Out(x, y, c) = node.rate[c];
  }

  void Interpolate(int x0, int y0, int size, const Node& a, const Node& b, const Node& c,
                   const Node& d) {
    const int width = std::min(size, region_.width - x0);
    const int height = std::min(size, region_.height - y0);
    const float step = 1.F / static_cast<float>(size);
    for (int plane = 0; plane < planes_; ++plane) {
      for (int j = 0; j < height; ++j) {
        const float down = static_cast<float>(j) * step;
        const float left = a.rate[plane] + down * (c.rate[plane] - a.rate[plane]);
        const float right = b.rate[plane] + down * (d.rate[plane] - b.rate[plane]);
        const float slope = (right - left) * step;
        float* out = Out(x0, y0 + j, plane);
        for (int i = 0; i < width; ++i) out[i] = left + slope * static_cast<float>(i);
      }
    }
  }

  float* Out(int x, int y, int plane) {
    return out_.data() + (static_cast<std::size_t>(plane) * region_.height + y) * region_.width + x;
  }

  SimOptics& optics_;
  const Pose pose_;
  const Brdf& sample_;
  const SimRegion region_;
  const int planes_;
  const Rgb scale_;
  std::vector<Node>& nodes_;
  std::vector<std::uint8_t>& states_;
  int stride_ = 0;
  std::vector<float> out_;
};

SimOptics::SimOptics(const SimConfig& truth, const Imaging& imaging, int sensor_width,
                     int sensor_height)
    : truth_(truth),
      imaging_(TrueImaging(imaging, truth)),
      every_px_(truth.target.kind == SimTarget::Kind::kNone ? truth.every_px : 1),
      sensor_width_(sensor_width),
      sensor_height_(sensor_height) {
  if (!resolves_directions()) return;
  GONIO_CHECK(std::isfinite(imaging.camera_distance), "an image of a camera at infinity");
  GONIO_CHECK(imaging.shape.kind == SampleShape::Kind::kFlat || imaging.shape.radius > 0, "radius");
}

std::optional<SurfaceView> SimOptics::See(const SimArms& arms, double x, double y) const {
  GONIO_CHECK(resolves_directions(), "no image");
  const Pose pose(*this, arms);
  return pose.See(pose.Ray(x, y));
}

Rgb SimOptics::UniformRate(const SimArms& arms, const Rgb& light, const Brdf& sample) const {
  const DirectionPair pair = Place(truth_.rig, arms).directions();
  const Rgb f_r = sample.Eval(pair).value_or(Rgb::Zero());
  return truth_.responsivity * (f_r.max(0) * std::max(pair.cos_theta_i(), 0.0) * light);
}

SimImage SimOptics::Render(const SimArms& arms, double power, const Brdf& sample,
                           const SimRegion& region, bool mono, const Rgb& spectrum) {
  SimImage image{.width = region.width, .height = region.height, .values = {}};
  if (power <= 0) return image;
  const Rgb light = power * spectrum;
  if (!resolves_directions()) {
    image.uniform = UniformRate(arms, light, sample) + truth_.stray_light * power;
    return image;
  }
  image.planes = mono ? 1 : kChannels;
  const int margin = static_cast<int>(std::ceil(3 * truth_.defocus));
  const SimRegion padded{region.x - margin, region.y - margin, region.width + 2 * margin,
                         region.height + 2 * margin};
  image.width = padded.width;
  image.height = padded.height;
  image.values = Renderer(*this, arms, light, sample, padded, mono).Run();
  if (margin > 0) image = Blur(image, truth_.defocus, margin);
  if (truth_.veiling_glare > 0) AddGlare(image, truth_.veiling_glare);
  for (float& value : image.values) value += static_cast<float>(truth_.stray_light * power);
  return image;
}

}  // namespace gonio
