// SPDX-License-Identifier: Apache-2.0
#include "brdf/merl_table.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <system_error>
#include <utility>
#include <vector>

#include "core/check.h"
#include "core/error.h"
#include "core/file.h"
#include "core/units.h"

namespace gonio {
namespace {

static_assert(std::endian::native == std::endian::little, "the file's byte order is assumed");

constexpr std::array<double, kChannels> kScale = {1.0 / 1500, 1.15 / 1500, 1.66 / 1500};
constexpr std::array<std::int32_t, 3> kDimensions = {MerlTable::kThetaH, MerlTable::kThetaD,
                                                     MerlTable::kPhiD};
constexpr double kInvalid = -1;

[[noreturn]] void Refuse(const std::filesystem::path& path, const std::string& complaint) {
  throw ConfigError(fmt::format("{}: {}", path.string(), complaint));
}

[[noreturn]] void RefuseUnreadable(const std::filesystem::path& path, int error) {
  Refuse(path, "cannot read: " + std::generic_category().message(error));
}

// An open file descriptor, closed on every way out.
struct Descriptor {
  int fd;
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
};

void CheckHeader(const std::filesystem::path& path, int fd, std::size_t size) {
  std::array<std::int32_t, 3> dimensions{};
  const bool whole = ::pread(fd, dimensions.data(), sizeof dimensions, 0) == sizeof dimensions;
  if (whole && dimensions != kDimensions) {
    Refuse(path, fmt::format("has dimensions {}, a MERL table has {}", fmt::join(dimensions, " x "),
                             fmt::join(kDimensions, " x ")));
  }
  if (size != MerlTable::kFileBytes) {
    Refuse(path, fmt::format("is {}: has {} bytes, a MERL table has {}",
                             size < MerlTable::kFileBytes ? "truncated" : "too long", size,
                             MerlTable::kFileBytes));
  }
}

std::shared_ptr<const void> MapFile(const std::filesystem::path& path) {
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  if (file.fd < 0) RefuseUnreadable(path, errno);
  struct stat status {};
  if (::fstat(file.fd, &status) != 0) RefuseUnreadable(path, errno);
  if (S_ISDIR(status.st_mode)) RefuseUnreadable(path, EISDIR);
  CheckHeader(path, file.fd, static_cast<std::size_t>(status.st_size));
  void* mapped = ::mmap(nullptr, MerlTable::kFileBytes, PROT_READ, MAP_PRIVATE, file.fd, 0);
  if (mapped == MAP_FAILED) RefuseUnreadable(path, errno);
  return {mapped, [](void* memory) { ::munmap(memory, MerlTable::kFileBytes); }};
}

// Offset in the file. Cells lie at 12 + 8n: never aligned for a double, so they are copied out.
std::size_t Offset(int channel, int cell) {
  return MerlTable::kHeaderBytes +
         sizeof(double) * (static_cast<std::size_t>(channel) * MerlTable::kCells + cell);
}

int CellIndex(int h, int d, int p) { return (h * MerlTable::kThetaD + d) * MerlTable::kPhiD + p; }

// False if any channel is invalid.
bool ReadCell(const std::byte* file, int cell, Rgb* f_r) {
  for (int c = 0; c < kChannels; ++c) {
    double stored;
    std::memcpy(&stored, file + Offset(c, cell), sizeof stored);
    if (!(stored >= 0 && stored <= std::numeric_limits<double>::max())) return false;
    (*f_r)[c] = stored * kScale[c];
  }
  return true;
}

void WriteCell(std::byte* file, int cell, const std::optional<Rgb>& f_r) {
  const bool valid = f_r && f_r->isFinite().all() && (*f_r >= 0).all();
  for (int c = 0; c < kChannels; ++c) {
    const double stored = valid ? (*f_r)[c] / kScale[c] : kInvalid;
    std::memcpy(file + Offset(c, cell), &stored, sizeof stored);
  }
}

// A position between two neighbouring cell centres of one axis.
struct Between {
  int low, high;  // may be the same
  double weight;  // of `high`, 0 .. 1
  int nearest() const { return weight < 0.5 ? low : high; }
};

// `position` counts cell centres from 0. Within 1e-9 of a centre rounding decides nothing: there
// the table's own number is wanted, not a blend with 1e-13 of the neighbour.
Between Place(double position) {
  const double centre = std::round(position);
  if (std::abs(position - centre) < 1e-9) position = centre;
  const int low = static_cast<int>(std::floor(position));
  return {low, low + 1, position - low};
}

Between PlaceClamped(double position, int size) {
  if (!(position > 0)) return {0, 0, 0};
  if (position >= size - 1) return {size - 1, size - 1, 0};
  return Place(position);
}

Between PlacePhi(double phi_d) {
  double turns = phi_d / kPi;
  turns -= std::floor(turns);
  const auto wrap = [](int p) { return (p + MerlTable::kPhiD) % MerlTable::kPhiD; };
  const Between place = Place(turns * MerlTable::kPhiD - 0.5);
  return {wrap(place.low), wrap(place.high), place.weight};
}

}  // namespace

MerlTable::MerlTable(std::string name, std::shared_ptr<const void> storage, const std::byte* file)
    : name_(std::move(name)), storage_(std::move(storage)), file_(file) {}

MerlTable MerlTable::Open(const std::filesystem::path& path) {
  auto mapping = MapFile(path);
  const auto* file = static_cast<const std::byte*>(mapping.get());
  Rgb f_r;
  int cell = 0;
  while (cell < kCells && !ReadCell(file, cell, &f_r)) ++cell;
  if (cell == kCells) {
    Refuse(path, "holds no valid cell: each has a channel that is negative or not finite");
  }
  return {path.stem().string(), std::move(mapping), file};
}

MerlTable MerlTable::FromFunction(std::string name, const BrdfFunction& f_r) {
  auto memory = std::make_shared<std::vector<std::byte>>(kFileBytes);
  std::byte* file = memory->data();
  std::memcpy(file, kDimensions.data(), kHeaderBytes);
  int cell = 0;
  for (int h = 0; h < kThetaH; ++h) {
    for (int d = 0; d < kThetaD; ++d) {
      for (int p = 0; p < kPhiD; ++p, ++cell) {
        const HalfDiff angles = CellCentre(h, d, p);
        double cos_i, cos_o;
        Cosines(angles, &cos_i, &cos_o);
        WriteCell(file, cell, cos_i > 0 && cos_o > 0 ? f_r(angles) : std::nullopt);
      }
    }
  }
  return {std::move(name), std::move(memory), file};
}

void MerlTable::Write(const std::filesystem::path& path) const {
  WriteFileAtomically(path, [this](std::ostream& out) {
    out.write(reinterpret_cast<const char*>(file_), static_cast<std::streamsize>(kFileBytes));
  });
}

HalfDiff MerlTable::CellCentre(int h, int d, int p) {
  const double warped = (h + 0.5) / kThetaH;
  return {.theta_h = warped * warped * (kPi / 2),
          .theta_d = (d + 0.5) / kThetaD * (kPi / 2),
          .phi_d = (p + 0.5) / kPhiD * kPi};
}

double MerlTable::ThetaHWidth(int h) { return (2.0 * h + 1) / (kThetaH * kThetaH) * (kPi / 2); }

std::optional<Rgb> MerlTable::Cell(int h, int d, int p) const {
  GONIO_CHECK(h >= 0 && h < kThetaH && d >= 0 && d < kThetaD && p >= 0 && p < kPhiD,
              fmt::format("cell {}, {}, {}", h, d, p));
  Rgb f_r;
  if (!ReadCell(file_, CellIndex(h, d, p), &f_r)) return std::nullopt;
  return f_r;
}

std::optional<Rgb> MerlTable::Eval(const HalfDiff& angles) const {
  double cos_i, cos_o;
  Cosines(angles, &cos_i, &cos_o);
  if (!(cos_i > 0 && cos_o > 0)) return std::nullopt;
  const double warped = std::sqrt(std::max(angles.theta_h, 0.0) / (kPi / 2));
  const Between h = PlaceClamped(warped * kThetaH - 0.5, kThetaH);
  const Between d = PlaceClamped(angles.theta_d / (kPi / 2) * kThetaD - 0.5, kThetaD);
  const Between p = PlacePhi(angles.phi_d);

  Rgb f_r, sum = Rgb::Zero();
  if (!ReadCell(file_, CellIndex(h.nearest(), d.nearest(), p.nearest()), &f_r)) return std::nullopt;
  double weights = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const bool high_h = corner & 1, high_d = corner & 2, high_p = corner & 4;
    const double weight = (high_h ? h.weight : 1 - h.weight) * (high_d ? d.weight : 1 - d.weight) *
                          (high_p ? p.weight : 1 - p.weight);
    if (weight <= 0) continue;
    const int cell =
        CellIndex(high_h ? h.high : h.low, high_d ? d.high : d.low, high_p ? p.high : p.low);
    if (!ReadCell(file_, cell, &f_r)) continue;
    sum += weight * f_r;
    weights += weight;
  }
  return Rgb(sum / weights);
}

}  // namespace gonio
