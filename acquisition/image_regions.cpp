// SPDX-License-Identifier: Apache-2.0
#include "acquisition/image_regions.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "brdf/camera_axes.h"
#include "core/check.h"
#include "core/units.h"

namespace gonio {
namespace {

using Eigen::Vector3d;

Vector3d ArmDirection(double azimuth, double elevation) {
  return FromSpherical(kPi / 2 - elevation, azimuth);
}

// What one pixel sees.
struct PixelView {
  std::uint32_t pixel = 0;
  DirectionPair pair;  // in the frame of the surface
  double light = 0;    // as in ImageRegion::lights
};

// Where a ray meets the sample's surface first, and its normal there.
struct Hit {
  Vector3d point;
  Vector3d normal;
};

// The nearer of the two points at which a ray meets a sphere or a cylinder of this radius below the
// origin; `counts` is 1 for the coordinates that count towards the distance from its middle.
std::optional<Hit> HitRound(const Vector3d& origin, const Vector3d& ray, double radius,
                            const Vector3d& counts) {
  const Vector3d to = (origin + Vector3d(0, 0, radius)).cwiseProduct(counts);
  const Vector3d along = ray.cwiseProduct(counts);
  const double a = along.squaredNorm();
  const double b = to.dot(along);
  const double c = to.squaredNorm() - radius * radius;
  const double root = b * b - a * c;
  if (root < 0 || a == 0) return std::nullopt;
  const double t = (-b - std::sqrt(root)) / a;
  if (t <= 0) return std::nullopt;
  const Vector3d point = origin + t * ray;
  return Hit{point, (point + Vector3d(0, 0, radius)).cwiseProduct(counts) / radius};
}

std::optional<Hit> HitSample(const SampleShape& shape, const Vector3d& origin,
                             const Vector3d& ray) {
  switch (shape.kind) {
    case SampleShape::Kind::kSphere:
      return HitRound(origin, ray, shape.radius, Vector3d::Ones());
    case SampleShape::Kind::kCylinder:
      return HitRound(origin, ray, shape.radius, Vector3d(0, 1, 1));
    case SampleShape::Kind::kFlat:
      break;
  }
  if (ray.z() >= 0) return std::nullopt;
  return Hit{origin - ray * (origin.z() / ray.z()), Vector3d::UnitZ()};
}

// The surface's frame in the sample's: columns x, y and the normal.
Eigen::Matrix3d FrameAt(const Vector3d& normal) {
  Vector3d x = Vector3d::UnitX() - normal.x() * normal;
  // Where the sample's x is along the normal, any will do.
  if (x.squaredNorm() < 1e-12) x = Vector3d::UnitY() - normal.y() * normal;
  x.normalize();
  Eigen::Matrix3d frame;
  frame << x, normal.cross(x), normal;
  return frame;
}

// Pinhole and light as the arms hold them, and the image's axes.
class View {
 public:
  View(const Imaging& imaging, const ArmAngles& arms, double max_polar)
      : imaging_(imaging), least_cosine_(std::cos(max_polar)) {
    const double azimuth = arms[kCameraAzimuth];
    const double elevation = arms[kCameraElevation];
    const Vector3d wo = ArmDirection(azimuth, elevation);
    camera_ = imaging.camera_distance * wo;
    light_ = ArmDirection(arms[kLightAzimuth], arms[kLightElevation]);
    axes_ = CameraAxes(imaging, azimuth, elevation);
  }

  // Of the pixel `x` to the right of the image's centre and `y` below it; empty if it sees nothing
  // that can be used.
  std::optional<PixelView> At(double x, double y) const {
    const Vector3d ray = (axes_ * PixelRay(imaging_, x, y)).normalized();
    const auto hit = HitSample(imaging_.shape, camera_, ray);
    if (!hit) return std::nullopt;
    if (imaging_.patch_radius > 0 && hit->point.norm() > imaging_.patch_radius) {
      return std::nullopt;
    }
    const auto [wi, distance_ratio] = ToLight(hit->point);
    const Eigen::Matrix3d into_frame = FrameAt(hit->normal).transpose();
    PixelView view;
    view.pair = {into_frame * wi, into_frame * -ray};
    if (view.pair.wi.z() < least_cosine_ || view.pair.wo.z() < least_cosine_) return std::nullopt;
    view.light = view.pair.wi.z() * distance_ratio * distance_ratio;
    return view;
  }

 private:
  // Direction from a point to the light, and d_L / |L - p|.
  std::pair<Vector3d, double> ToLight(const Vector3d& point) const {
    if (!std::isfinite(imaging_.light_distance)) return {light_, 1};
    const Vector3d way = imaging_.light_distance * light_ - point;
    return {way.normalized(), imaging_.light_distance / way.norm()};
  }

  const Imaging& imaging_;
  const double least_cosine_;
  Vector3d camera_;
  Vector3d light_;  // direction
  Eigen::Matrix3d axes_;
};

std::vector<PixelView> ViewsOf(const Imaging& imaging, const ArmAngles& arms, int width, int height,
                               double max_polar) {
  const View view(imaging, arms, max_polar);
  std::vector<PixelView> views;
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      auto seen = view.At(column + 0.5 - width / 2.0, row + 0.5 - height / 2.0);
      if (!seen) continue;
      seen->pixel = static_cast<std::uint32_t>(row) * width + column;
      views.push_back(*seen);
    }
  }
  return views;
}

// What must be alike within a region: x and y of the half vector, and theta_d.
Vector3d Coordinates(const PixelView& view) {
  const Vector3d half = (view.pair.wi + view.pair.wo).normalized();
  return {half.x(), half.y(), AngleBetween(view.pair.wi, half)};
}

using Views = std::vector<PixelView>::iterator;

// Halves [begin, end) `times` times, each time where it spreads most, and hands out the parts.
template <typename Take>
void Halve(Views begin, Views end, int times, const Take& take) {
  if (times == 0 || end - begin < 2) return take(begin, end);
  Vector3d low = Coordinates(*begin);
  Vector3d high = low;
  for (Views view = begin; view != end; ++view) {
    const Vector3d at = Coordinates(*view);
    low = low.cwiseMin(at);
    high = high.cwiseMax(at);
  }
  int axis = 0;
  (high - low).maxCoeff(&axis);
  const Views middle = begin + (end - begin) / 2;
  std::nth_element(begin, middle, end, [axis](const PixelView& a, const PixelView& b) {
    return std::pair(Coordinates(a)[axis], a.pixel) < std::pair(Coordinates(b)[axis], b.pixel);
  });
  Halve(begin, middle, times - 1, take);
  Halve(middle, end, times - 1, take);
}

ImageRegion Join(Views begin, Views end) {
  std::sort(begin, end, [](const PixelView& a, const PixelView& b) { return a.pixel < b.pixel; });
  ImageRegion region;
  Vector3d wi = Vector3d::Zero();
  Vector3d wo = Vector3d::Zero();
  for (Views view = begin; view != end; ++view) {
    region.pixels.push_back(view->pixel);
    region.lights.push_back(static_cast<float>(view->light));
    region.light += view->light;
    wi += view->pair.wi;
    wo += view->pair.wo;
  }
  region.light /= static_cast<double>(end - begin);
  region.directions = {wi.normalized(), wo.normalized()};
  return region;
}

DirectionPair DirectionsOf(const ArmAngles& arms) {
  return {ArmDirection(arms[kLightAzimuth], arms[kLightElevation]),
          ArmDirection(arms[kCameraAzimuth], arms[kCameraElevation])};
}

ImageRegion AllPixels(const ArmAngles& arms, int width, int height) {
  ImageRegion region;
  region.directions = DirectionsOf(arms);
  region.pixels.resize(static_cast<std::size_t>(width) * height);
  std::iota(region.pixels.begin(), region.pixels.end(), 0u);
  region.light = region.directions.cos_theta_i();
  return region;
}

// How far a region looks from the directions of the arms [rad].
double Astray(const ImageRegion& region, const DirectionPair& arms) {
  return AngleBetween(region.directions.wi, arms.wi) + AngleBetween(region.directions.wo, arms.wo);
}

}  // namespace

std::vector<ImageRegion> RegionsOf(const Imaging& imaging, const ArmAngles& arms, int width,
                                   int height, double max_polar, int count) {
  GONIO_CHECK(count >= 1 && (count & (count - 1)) == 0, "not a power of two");
  if (!imaging.resolves_directions()) return {AllPixels(arms, width, height)};
  std::vector<PixelView> views = ViewsOf(imaging, arms, width, height, max_polar);
  std::vector<ImageRegion> regions;
  if (views.empty()) return regions;
  int halvings = 0;
  while ((1 << halvings) < count) ++halvings;
  Halve(views.begin(), views.end(), halvings, [&](Views begin, Views end) {
    if (begin != end) regions.push_back(Join(begin, end));
  });
  const DirectionPair centre = DirectionsOf(arms);
  const auto nearest = std::min_element(regions.begin(), regions.end(),
                                        [&](const ImageRegion& a, const ImageRegion& b) {
                                          return Astray(a, centre) < Astray(b, centre);
                                        });
  std::rotate(regions.begin(), nearest, nearest + 1);
  return regions;
}

void LeaveOut(const std::vector<std::uint8_t>& marked, int per_pixel,
              std::vector<ImageRegion>* regions) {
  const auto is_marked = [&](std::uint32_t pixel) {
    const std::size_t first = std::size_t{pixel} * static_cast<std::size_t>(per_pixel);
    return std::any_of(marked.begin() + static_cast<std::ptrdiff_t>(first),
                       marked.begin() + static_cast<std::ptrdiff_t>(first) + per_pixel,
                       [](std::uint8_t bits) { return bits != 0; });
  };
  for (ImageRegion& region : *regions) {
    std::size_t kept = 0;
    double light = 0;
    for (std::size_t i = 0; i < region.pixels.size(); ++i) {
      if (is_marked(region.pixels[i])) continue;
      region.pixels[kept] = region.pixels[i];
      if (!region.lights.empty()) light += region.lights[kept] = region.lights[i];
      ++kept;
    }
    if (kept == region.pixels.size()) continue;
    region.pixels.resize(kept);
    if (region.lights.empty()) continue;
    region.lights.resize(kept);
    region.light = light / static_cast<double>(kept);
  }
  std::erase_if(*regions, [](const ImageRegion& region) { return region.pixels.empty(); });
}

}  // namespace gonio
