// SPDX-License-Identifier: Apache-2.0
#include "brdf/render/sphere.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <optional>
#include <thread>
#include <vector>

#include "brdf/render/half_vector_sampler.h"
#include "core/error.h"
#include "core/units.h"

namespace gonio {
namespace {

constexpr double kMargin = 0.04;  // of the image's width, on each side

// A point of the sphere that the camera sees, with a frame in which z is the normal.
struct Surface {
  Eigen::Matrix3d to_local;  // rows: tangent, bitangent, normal
  Eigen::Vector3d wo;        // towards the camera, local
};

// `x`, `y` in pixels from the top left; empty beside the sphere.
std::optional<Surface> SeenAt(double x, double y, int size) {
  const double radius = size * (0.5 - kMargin);
  const double nx = (x - size / 2.0) / radius;
  const double ny = (size / 2.0 - y) / radius;
  const double rest = 1 - nx * nx - ny * ny;
  if (rest <= 0) return std::nullopt;
  const Eigen::Vector3d normal(nx, ny, std::sqrt(rest));
  const Eigen::Vector3d tangent = normal.unitOrthogonal();
  Surface surface;
  surface.to_local.row(0) = tangent;
  surface.to_local.row(1) = normal.cross(tangent);
  surface.to_local.row(2) = normal;
  surface.wo = surface.to_local.col(2);  // of (0, 0, 1)
  return surface;
}

// f_r cos theta_i; zero where it is unknown.
Rgb Reflected(const Brdf& brdf, const Eigen::Vector3d& wi, const Eigen::Vector3d& wo) {
  const std::optional<Rgb> f_r = brdf.Eval(DirectionPair{wi, wo});
  if (!f_r || !f_r->isFinite().all()) return Rgb::Zero();
  return *f_r * wi.z();
}

// Rows are independent of each other, so that it does not matter who does which.
template <typename Pixel>
Image RenderPixels(const RenderOptions& options, const Pixel& pixel) {
  options.Check();
  Image image(options.size, options.size);
  const auto work = [&](int first) {
    for (int y = first; y < options.size; y += options.threads) {
      for (int x = 0; x < options.size; ++x) image.at(x, y) = pixel(x, y).template cast<float>();
    }
  };
  std::vector<std::jthread> helpers;
  for (int t = 1; t < options.threads; ++t) helpers.emplace_back(work, t);
  work(0);
  helpers.clear();  // joins
  return image;
}

// Four numbers that fill the unit cube evenly as `i` counts up: a Kronecker sequence whose steps
// are powers of the root of x^5 = x + 1, the generalised golden ratio.
struct Point4 {
  double a, b, u, v;
};
class Sequence {
 public:
  // Each pixel begins elsewhere, so that errors look like noise and not like a pattern.
  explicit Sequence(std::uint32_t pixel) {
    std::uint64_t state = pixel * 0x9e3779b97f4a7c15ull + 0x632be59bd9b4e019ull;
    for (double& shift : shift_) {
      state ^= state >> 31;
      state *= 0xbf58476d1ce4e5b9ull;
      state ^= state >> 29;
      shift = static_cast<double>(state >> 11) * 0x1.0p-53;
    }
  }
  Point4 At(int i) const {
    constexpr double kRoot = 1.1673039782614187;
    const auto coordinate = [&](int d, double step) {
      const double at = shift_[d] + i * step;
      return at - std::floor(at);
    };
    const double r = 1 / kRoot;
    return {coordinate(0, r), coordinate(1, r * r), coordinate(2, r * r * r),
            coordinate(3, r * r * r * r)};
  }

 private:
  double shift_[4];
};

// Sends light from all around to the camera, by three ways of choosing its direction.
class Integrator {
 public:
  Integrator(const Brdf& brdf, const Environment& environment)
      : brdf_(brdf), environment_(environment), halves_(brdf) {}

  // The sum of the three ways' contributions, each weighed by the balance heuristic.
  Rgb Sample(const Surface& surface, double u, double v) const {
    const Environment::Sample light = environment_.Draw(u, v);
    Rgb sum = Contribution(surface, surface.to_local * light.direction);
    const Eigen::Vector3d half = halves_.Draw(u, v);
    sum += Contribution(surface, 2 * half.dot(surface.wo) * half - surface.wo);
    const double radius = std::sqrt(u);
    sum += Contribution(surface, {radius * std::cos(2 * kPi * v), radius * std::sin(2 * kPi * v),
                                  std::sqrt(1 - u)});
    return sum;
  }

 private:
  Rgb Contribution(const Surface& surface, const Eigen::Vector3d& wi) const {
    if (wi.z() <= 0) return Rgb::Zero();
    const Eigen::Vector3d direction = surface.to_local.transpose() * wi;
    const Eigen::Vector3d half = (wi + surface.wo).normalized();
    const double pdf = environment_.Pdf(direction) +
                       halves_.Pdf(half) / (4 * std::max(half.dot(surface.wo), 1e-9)) +
                       wi.z() / kPi;
    return Reflected(brdf_, wi, surface.wo) * environment_.Radiance(direction).cast<double>() / pdf;
  }

  const Brdf& brdf_;
  const Environment& environment_;
  HalfVectorSampler halves_;
};

}  // namespace

void RenderOptions::Check() const {
  const auto require = [](int number, int min, int max, const char* name) {
    if (number < min || number > max) {
      throw ConfigError(
          fmt::format("{}: is {}, must be between {} and {}", name, number, min, max));
    }
  };
  require(size, 16, 4096, "size");
  require(samples, 1, 65536, "samples");
  require(supersample, 1, 16, "supersample");
  require(threads, 1, 1024, "threads");
}

Image RenderUnderPoint(const Brdf& brdf, const RenderOptions& options,
                       const Eigen::Vector3d& light) {
  return RenderPixels(options, [&](int x, int y) {
    Rgb sum = Rgb::Zero();
    const int n = options.supersample;
    for (int i = 0; i < n * n; ++i) {
      const auto surface = SeenAt(x + (i % n + 0.5) / n, y + (i / n + 0.5) / n, options.size);
      if (!surface) continue;
      const Eigen::Vector3d wi = surface->to_local * light;
      if (wi.z() > 0) sum += kPi * Reflected(brdf, wi, surface->wo);
    }
    return Rgb(sum / (n * n));
  });
}

Image RenderUnder(const Brdf& brdf, const Environment& environment, const RenderOptions& options) {
  const Integrator integrator(brdf, environment);
  const int count = (options.samples + 2) / 3;  // three directions for each
  return RenderPixels(options, [&](int x, int y) {
    const Sequence sequence(static_cast<std::uint32_t>(y * options.size + x));
    Rgb sum = Rgb::Zero();
    for (int i = 0; i < count; ++i) {
      const Point4 at = sequence.At(i);
      const auto surface = SeenAt(x + at.a, y + at.b, options.size);
      if (surface) sum += integrator.Sample(*surface, at.u, at.v);
    }
    return Rgb(sum / count);
  });
}

}  // namespace gonio
