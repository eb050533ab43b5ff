// SPDX-License-Identifier: Apache-2.0
#include "brdf/rgl_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "brdf/bilinear_density.h"
#include "brdf/tensor_file.h"
#include "core/units.h"

namespace gonio {
namespace {

// Interpolated f_r is known if at least this share of its weight lies on points that were measured.
constexpr double kKnownShare = 0.5;

// The file's coordinates of a direction: dense near the normal, and the azimuth from -pi to pi.
Point2 ToSquare(double theta, double phi) {
  const double turn = (phi + kPi) / (2 * kPi);
  return {std::sqrt(theta * 2 / kPi), turn - std::floor(turn)};
}

double Theta(const Eigen::Vector3d& w) { return std::atan2(std::hypot(w.x(), w.y()), w.z()); }
double Phi(const Eigen::Vector3d& w) { return std::atan2(w.y(), w.x()); }

}  // namespace

struct RglTable::Data {
  std::string name;
  std::string description;
  std::vector<float> theta_i;  // rad, ascending
  // The distribution of normals and the projected area of those that the light sees, 2D grids.
  std::vector<float> ndf, sigma;
  int ndf_rows = 0, ndf_columns = 0, sigma_rows = 0, sigma_columns = 0;
  BilinearDensity vndf;    // of visible normals, one grid for each theta_i
  std::vector<float> rgb;  // theta_i x channel x rows x columns
  int rows = 0, columns = 0;
  std::vector<bool> valid;  // theta_i x rows x columns
  bool jacobian = false;

  void ReadGrids(const TensorFile& file);
  void ReadValid(const TensorFile& file);
  bool AboveHorizon(int t, int y, int x) const;
  Rgb Interpolate(Point2 at, int t, double fraction, double* known) const;
};

namespace {

double EvalGrid(const std::vector<float>& grid, int rows, int columns, Point2 at) {
  const auto [x, fx] = PlaceOnGrid(at[0], columns);
  const auto [y, fy] = PlaceOnGrid(at[1], rows);
  const float* here = grid.data() + std::size_t(y) * columns + x;
  return (1 - fy) * ((1 - fx) * here[0] + fx * here[1]) +
         fy * ((1 - fx) * here[columns] + fx * here[columns + 1]);
}

// A field with two dimensions of at least two points each.
std::vector<float> ReadGrid(const TensorFile& file, const char* name, int* rows, int* columns) {
  const std::vector<std::size_t>& shape = file.Shape(name);
  if (shape.size() != 2 || shape[0] < 2 || shape[1] < 2) {
    file.Fail(fmt::format("field {} is no grid with two dimensions", name));
  }
  *rows = static_cast<int>(shape[0]);
  *columns = static_cast<int>(shape[1]);
  return file.Floats(name);
}

void RequireNonNegative(const TensorFile& file, const char* name, const std::vector<float>& grid) {
  if (std::any_of(grid.begin(), grid.end(), [](float x) { return x < 0; })) {
    file.Fail(fmt::format("field {} holds a negative number", name));
  }
}

}  // namespace

void RglTable::Data::ReadGrids(const TensorFile& file) {
  theta_i = file.Floats("theta_i");
  const std::size_t thetas = theta_i.size();
  if (thetas < 2 || !std::is_sorted(theta_i.begin(), theta_i.end(), std::less_equal<>())) {
    file.Fail("field theta_i does not ascend");
  }
  if (theta_i.front() < 0 || theta_i.back() > kPi / 2 + 1e-4) {
    file.Fail("field theta_i leaves 0 to 90 deg");
  }
  ndf = ReadGrid(file, "ndf", &ndf_rows, &ndf_columns);
  sigma = ReadGrid(file, "sigma", &sigma_rows, &sigma_columns);
  const std::vector<std::size_t> visible = file.Shape("vndf");
  if (visible.size() != 4 || visible[2] < 2 || visible[3] < 2) {
    file.Fail("field vndf has not four dimensions");
  }
  const std::vector<float> densities = file.Floats("vndf", {1, thetas, visible[2], visible[3]});
  RequireNonNegative(file, "vndf", densities);
  vndf = BilinearDensity(densities, static_cast<int>(thetas), static_cast<int>(visible[2]),
                         static_cast<int>(visible[3]));
  const std::vector<std::size_t> colours = file.Shape("rgb");
  if (colours.size() != 5 || colours[3] < 2 || colours[4] < 2) {
    file.Fail("field rgb has not five dimensions");
  }
  rgb = file.Floats("rgb", {1, thetas, kChannels, colours[3], colours[4]});
  rows = static_cast<int>(colours[3]);
  columns = static_cast<int>(colours[4]);
}

// Whether the direction that point (x, y) of the rgb grid stands for lies above the horizon.
bool RglTable::Data::AboveHorizon(int t, int y, int x) const {
  const Point2 at = vndf.FromUniform({x / (columns - 1.0), y / (rows - 1.0)}, t);
  const Eigen::Vector3d m = FromSpherical(at[0] * at[0] * kPi / 2, (2 * at[1] - 1) * kPi);
  const Eigen::Vector3d wi = FromSpherical(theta_i[t], 0);
  return (2 * m.dot(wi) * m - wi).z() > 0;
}

// One bit for each point of the rgb grid, theta_i by theta_i, the first in a byte's highest bit. In
// some files it says that the point is valid, in others that it is not; the field means the same as
// the horizon, so that tells which. The last theta_i is 90 deg, where the horizon is a matter of
// rounding.
void RglTable::Data::ReadValid(const TensorFile& file) {
  const std::size_t points = theta_i.size() * rows * columns;
  const std::vector<std::uint8_t> bytes = file.Bytes("valid", {(points + 7) / 8});
  valid.resize(points);
  std::size_t compared = 0;
  std::size_t agree = 0;
  for (std::size_t i = 0; i < points; ++i) {
    valid[i] = (bytes[i / 8] >> (7 - i % 8)) & 1;
    const int t = static_cast<int>(i / (std::size_t(rows) * columns));
    if (t + 1 == static_cast<int>(theta_i.size())) continue;
    const int y = static_cast<int>(i / columns % rows);
    const int x = static_cast<int>(i % columns);
    ++compared;
    agree += AboveHorizon(t, y, x) == valid[i];
  }
  if (2 * agree < compared) valid.flip();
}

RglTable RglTable::Open(const std::filesystem::path& path) {
  const TensorFile file = TensorFile::Open(path);
  if (!file.Has("rgb") && file.Has("spectra")) {
    file.Fail("is spectral; only the RGB files are read (NAME_rgb.bsdf)");
  }
  const std::size_t azimuths = file.Floats("phi_i").size();
  if (azimuths > 1) {
    file.Fail(fmt::format("is anisotropic ({} phi_i); only isotropic files are read", azimuths));
  }
  auto data = std::make_shared<Data>();
  data->name = path.stem().string();
  const std::vector<std::uint8_t> text = file.Bytes("description");
  data->description.assign(text.begin(), text.end());
  data->jacobian = file.Bytes("jacobian", {1})[0] != 0;
  data->ReadGrids(file);
  data->ReadValid(file);
  return RglTable(std::move(data));
}

// Linear between the four points around `at` and the two theta_i; points that are not valid are
// left out and the others' weights scaled up. `known` is the share that was left.
Rgb RglTable::Data::Interpolate(Point2 at, int t, double fraction, double* known) const {
  const auto [x, fx] = PlaceOnGrid(at[0], columns);
  const auto [y, fy] = PlaceOnGrid(at[1], rows);
  const std::size_t plane = std::size_t(rows) * columns;
  Rgb sum = Rgb::Zero();
  *known = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const bool right = (corner & 1) != 0;
    const bool lower = (corner & 2) != 0;
    const bool after = (corner & 4) != 0;
    const double weight =
        (right ? fx : 1 - fx) * (lower ? fy : 1 - fy) * (after ? fraction : 1 - fraction);
    const std::size_t point = std::size_t(y + lower) * columns + x + right;
    if (weight == 0 || !valid[(t + after) * plane + point]) continue;
    for (int c = 0; c < kChannels; ++c) {
      sum[c] += weight * rgb[((t + after) * kChannels + c) * plane + point];
    }
    *known += weight;
  }
  return sum / *known;
}

std::optional<Rgb> RglTable::EvalDirected(const DirectionPair& pair) const {
  if (!pair.above_horizon()) return std::nullopt;
  const double theta_i = Theta(pair.wi);
  const std::vector<float>& grid = data_->theta_i;
  constexpr double kRounding = 1e-6;
  if (theta_i < grid.front() - kRounding || theta_i > grid.back() + kRounding) return std::nullopt;
  const auto after = std::clamp<std::ptrdiff_t>(
      std::upper_bound(grid.begin(), grid.end(), theta_i) - grid.begin(), 1, std::ssize(grid) - 1);
  const int t = static_cast<int>(after) - 1;
  const double fraction = std::clamp((theta_i - grid[t]) / (grid[t + 1] - grid[t]), 0.0, 1.0);

  const Eigen::Vector3d m = (pair.wi + pair.wo).normalized();
  const Point2 normal = ToSquare(Theta(m), Phi(m) - Phi(pair.wi));
  double known = 0;
  Rgb f_r_cos = data_->Interpolate(data_->vndf.ToUniform(normal, t, fraction), t, fraction, &known);
  if (known < kKnownShare) return std::nullopt;
  if (data_->jacobian) {
    const double d = EvalGrid(data_->ndf, data_->ndf_rows, data_->ndf_columns, normal);
    const double area = EvalGrid(data_->sigma, data_->sigma_rows, data_->sigma_columns,
                                 ToSquare(theta_i, Phi(pair.wi)));
    f_r_cos *= d / (4 * area);
  }
  const Rgb f_r = f_r_cos / pair.cos_theta_o();
  if (!f_r.isFinite().all()) return std::nullopt;
  return f_r;
}

std::optional<Rgb> RglTable::Eval(const HalfDiff& angles) const {
  const DirectionPair pair = ToDirections(angles);
  const std::optional<Rgb> one = EvalDirected(pair);
  const std::optional<Rgb> other = EvalDirected({pair.wo, pair.wi});
  if (one && other) return 0.5 * (*one + *other);
  return one ? one : other;
}

std::string RglTable::name() const { return data_->name; }
const std::string& RglTable::description() const { return data_->description; }

}  // namespace gonio
