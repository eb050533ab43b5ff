// SPDX-License-Identifier: Apache-2.0
#include "acquisition/radiometry/hdr_merge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "brdf/brdf.h"
#include "core/check.h"

namespace gonio {
namespace {

constexpr double kDarkSigmas = 3;

double Square(double x) { return x * x; }

// Sites of one channel of one tile in one frame: signal, saturated ones at their clipped value.
struct TileSum {
  double electrons = 0;
  double sites = 0;
};

// The rows of one row of tiles. Bayer mosaics have two kinds of rows.
struct Band {
  int first = 0;
  int end = 0;
  int tiles = 0;
};

// What one frame contributes to each site of a row.
struct RowWeights {
  std::vector<float> signal;  // w / g
  std::vector<float> weight;  // w
  std::vector<float> shot;    // w^2 / g
  std::vector<float> floor;   // w^2 f / g^2
  std::vector<float> extra;   // w^2 / g^2
  std::vector<float> square;  // w^2
  void resize(std::size_t n) {
    for (auto* row : {&signal, &weight, &shot, &floor, &extra, &square}) row->resize(n);
  }
};

// Sums over the frames, of one row.
struct RowSums {
  std::vector<float> signal, weight, variance_rate, variance_floor, square;
  SiteMask faults;
  explicit RowSums(std::size_t n)
      : signal(n), weight(n), variance_rate(n), variance_floor(n), square(n), faults(n) {}
  void Clear() {
    for (auto* row : {&signal, &weight, &variance_rate, &variance_floor, &square}) {
      std::fill(row->begin(), row->end(), 0.0F);
    }
    std::fill(faults.begin(), faults.end(), std::uint8_t{0});
  }
};

// electrons^2: variance of a site without signal, on average over all.
double TypicalFloor(const CorrectedFrame& frame) {
  if (frame.extra.empty()) return frame.floor;
  double extra = 0;
  for (const float e : frame.extra) extra += e;
  return frame.floor + extra / static_cast<double>(frame.extra.size());
}

// 1 below taper_begin of full scale, 0 above taper_end, smooth in between.
double Taper(double level, const MergeOptions& options) {
  const double u = (options.taper_end - level) / (options.taper_end - options.taper_begin);
  const double v = std::clamp(u, 0.0, 1.0);
  return v * v * (3 - 2 * v);
}

// Weights of all frames for one rate, the largest 1; all 0 if it saturates each.
std::vector<double> WeightsFor(const std::vector<CorrectedFrame>& frames,
                               const std::vector<double>& floors, double rate,
                               const MergeOptions& options) {
  std::vector<double> weights;
  double largest = 0;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const double g = frames[k].gain();
    const double alone = (rate * g + floors[k]) / options.averaged_sites;
    const double shared = Square(options.shared_noise * rate * g);
    const double taper = Taper(rate * g / frames[k].full, options);
    weights.push_back(Square(g) / (alone + shared) * taper);
    largest = std::max(largest, weights.back());
  }
  for (double& w : weights) w = largest > 0 ? w / largest : 0;
  return weights;
}

class Merger {
 public:
  Merger(const std::vector<CorrectedFrame>& frames, const MergeOptions& options)
      : frames_(frames),
        options_(options),
        format_(frames.front().format),
        row_(static_cast<std::size_t>(RowSites(format_))),
        per_pixel_(CountsPerPixel(format_.layout)),
        sums_(row_) {
    for (int parity = 0; parity < 2; ++parity) {
      channels_[static_cast<std::size_t>(parity)] = RowChannels(format_, parity);
      weights_[static_cast<std::size_t>(parity)].resize(frames.size());
      for (auto& w : weights_[static_cast<std::size_t>(parity)]) w.resize(row_);
    }
    for (const CorrectedFrame& frame : frames) {
      typical_floor_.push_back(TypicalFloor(frame));
      order_.push_back(order_.size());
    }
    std::sort(order_.begin(), order_.end(),
              [&](auto a, auto b) { return frames[a].gain() < frames[b].gain(); });
  }

  MergedImage Run() {
    MergedImage merged;
    merged.format = format_;
    merged.rate.resize(format_.sites());
    merged.variance.resize(format_.sites());
    merged.shared.resize(format_.sites());
    merged.state.resize(format_.sites());
    for (int y = 0; y < format_.height; y += options_.tile) {
      const Band band{y, std::min(y + options_.tile, format_.height),
                      (format_.width + options_.tile - 1) / options_.tile};
      SetWeights(band);
      for (int row = band.first; row < band.end; ++row) MergeRow(row, &merged);
    }
    return merged;
  }

 private:
  using TileSums = std::vector<std::array<TileSum, kChannels>>;  // by tile

  TileSums SumTiles(const Band& band, const CorrectedFrame& frame) {
    TileSums tiles(static_cast<std::size_t>(band.tiles));
    // Columns first, which the compiler can do many at a time; rows of a mosaic by parity.
    for (std::size_t parity = 0; parity < 2; ++parity) {
      column_electrons_.assign(row_, 0.0F);
      column_sites_.assign(row_, 0.0F);
      for (int y = band.first + static_cast<int>(parity); y < band.end; y += 2) {
        AddRow(frame, static_cast<std::size_t>(y) * row_);
      }
      for (std::size_t x = 0; x < row_; ++x) {
        TileSum& sum = tiles[TileOf(x)][channels_[RowKind(band, parity)][x]];
        sum.electrons += column_electrons_[x];
        sum.sites += column_sites_[x];
      }
    }
    return tiles;
  }

  void AddRow(const CorrectedFrame& frame, std::size_t start) {
    const float* __restrict electrons = frame.electrons.data() + start;
    const std::uint8_t* __restrict unusable = frame.unusable.data() + start;
    float* __restrict sum = column_electrons_.data();
    float* __restrict sites = column_sites_.data();
    for (std::size_t x = 0; x < row_; ++x) {
      const float good = (unusable[x] & kBadSite) == 0 ? 1.0F : 0.0F;
      sum[x] += good * electrons[x];
      sites[x] += good;
    }
  }

  static std::size_t RowKind(const Band& band, std::size_t parity) {
    return (static_cast<std::size_t>(band.first) + parity) & 1;
  }
  std::size_t TileOf(std::size_t x) const {
    return x / static_cast<std::size_t>(per_pixel_ * options_.tile);
  }

  // Expected rate of one channel of a tile, at least zero: from the shortest frame on, each next
  // one if what is known so far and what itself says leave it below full scale.
  double ExpectedRate(const std::vector<TileSums>& sums, std::size_t tile, std::size_t c) const {
    double electrons = 0;
    double seconds = 0;
    for (const std::size_t k : order_) {
      const TileSum& sum = sums[k][tile][c];
      if (sum.sites == 0) continue;
      const double mean = sum.electrons / sum.sites;
      const double known = seconds > 0 ? electrons / seconds * frames_[k].gain() : mean;
      const double limit = options_.taper_end * frames_[k].full;
      if (seconds > 0 && std::max(known, mean) >= limit) break;
      electrons += mean;
      seconds += frames_[k].gain();
    }
    return seconds > 0 ? std::max(0.0, electrons / seconds) : 0;
  }

  void SetWeights(const Band& band) {
    std::vector<TileSums> sums;
    for (const CorrectedFrame& frame : frames_) sums.push_back(SumTiles(band, frame));
    std::vector<std::array<std::vector<double>, kChannels>> weights(
        static_cast<std::size_t>(band.tiles));
    const auto channels = static_cast<std::size_t>(ChannelsOf(format_.layout));
    for (std::size_t tile = 0; tile < weights.size(); ++tile) {
      for (std::size_t c = 0; c < channels; ++c) {
        weights[tile][c] =
            WeightsFor(frames_, typical_floor_, ExpectedRate(sums, tile, c), options_);
      }
    }
    const std::size_t kinds = channels == 1 || per_pixel_ == kChannels ? 1 : 2;
    for (std::size_t kind = 0; kind < kinds; ++kind) {
      for (std::size_t k = 0; k < frames_.size(); ++k) {
        const double g = frames_[k].gain();
        RowWeights& row = weights_[kind][k];
        for (std::size_t x = 0; x < row_; ++x) {
          const double w = weights[TileOf(x)][channels_[kind][x]][k];
          row.signal[x] = static_cast<float>(w / g);
          row.weight[x] = static_cast<float>(w);
          row.shot[x] = static_cast<float>(w * w / g);
          row.floor[x] = static_cast<float>(w * w * frames_[k].floor / (g * g));
          row.extra[x] = static_cast<float>(w * w / (g * g));
          row.square[x] = static_cast<float>(w * w);
        }
      }
    }
    bayer_ = kinds == 2;
  }

  void AddFrame(const CorrectedFrame& frame, const RowWeights& weights, std::size_t start) {
    const float* __restrict electrons = frame.electrons.data() + start;
    const std::uint8_t* __restrict unusable = frame.unusable.data() + start;
    const float* __restrict w_signal = weights.signal.data();
    const float* __restrict w = weights.weight.data();
    const float* __restrict w_shot = weights.shot.data();
    const float* __restrict w_floor = weights.floor.data();
    const float* __restrict w_square = weights.square.data();
    float* __restrict signal = sums_.signal.data();
    float* __restrict weight = sums_.weight.data();
    float* __restrict rate = sums_.variance_rate.data();
    float* __restrict floor = sums_.variance_floor.data();
    float* __restrict square = sums_.square.data();
    std::uint8_t* __restrict faults = sums_.faults.data();
    for (std::size_t x = 0; x < row_; ++x) {
      const float good = unusable[x] == 0 ? 1.0F : 0.0F;
      signal[x] += good * w_signal[x] * electrons[x];
      weight[x] += good * w[x];
      rate[x] += good * w_shot[x];
      floor[x] += good * w_floor[x];
      square[x] += good * w_square[x];
      faults[x] |= unusable[x];
    }
    if (frame.extra.empty()) return;
    const float* __restrict extra = frame.extra.data() + start;
    const float* __restrict w_extra = weights.extra.data();
    for (std::size_t x = 0; x < row_; ++x) {
      floor[x] += unusable[x] == 0 ? w_extra[x] * extra[x] : 0.0F;
    }
  }

  void MergeRow(int y, MergedImage* merged) {
    const std::size_t start = static_cast<std::size_t>(y) * row_;
    sums_.Clear();
    const auto& weights = weights_[bayer_ ? static_cast<std::size_t>(y & 1) : 0];
    for (std::size_t k = 0; k < frames_.size(); ++k) AddFrame(frames_[k], weights[k], start);
    const float common = static_cast<float>(Square(options_.shared_noise));
    const auto dark = static_cast<float>(Square(kDarkSigmas));
    constexpr float kUnknown = std::numeric_limits<float>::infinity();
    for (std::size_t x = 0; x < row_; ++x) {
      const bool known = sums_.weight[x] > 0;
      const float scale = known ? 1 / sums_.weight[x] : 0;
      const float rate = sums_.signal[x] * scale;
      const float positive = std::max(rate, 0.0F);
      const float variance =
          (positive * sums_.variance_rate[x] + sums_.variance_floor[x]) * scale * scale;
      merged->rate[start + x] = rate;
      merged->variance[start + x] = known ? variance : kUnknown;
      merged->shared[start + x] = common * sums_.square[x] * scale * scale;
      const bool bad = (sums_.faults[x] & kBadSite) != 0;
      const bool faint = positive * positive < dark * variance;
      const int unknown = bad ? kAllBad : kAllSaturated;
      const int seen = faint ? kAllDark : 0;
      merged->state[start + x] = static_cast<std::uint8_t>(known ? seen : unknown);
    }
  }

  const std::vector<CorrectedFrame>& frames_;
  const MergeOptions options_;
  const SensorFormat& format_;
  const std::size_t row_;  // sites
  const int per_pixel_;
  bool bayer_ = false;
  std::array<std::vector<std::uint8_t>, 2> channels_;
  std::array<std::vector<RowWeights>, 2> weights_;  // by kind of row, frame
  std::vector<double> typical_floor_;               // electrons^2, by frame
  std::vector<std::size_t> order_;                  // frames by ascending gain
  std::vector<float> column_electrons_;
  std::vector<float> column_sites_;
  RowSums sums_;
};

}  // namespace

std::vector<double> MergeWeights(const std::vector<CorrectedFrame>& frames, double rate,
                                 const MergeOptions& options) {
  std::vector<double> floors;
  for (const CorrectedFrame& frame : frames) floors.push_back(TypicalFloor(frame));
  return WeightsFor(frames, floors, rate, options);
}

Result<MergedImage> Merge(const std::vector<CorrectedFrame>& frames, const MergeOptions& options) {
  GONIO_CHECK(options.tile >= 2 && options.tile % 2 == 0, "tiles hold whole cells of a mosaic");
  GONIO_CHECK(options.taper_begin < options.taper_end, "a taper ends after its beginning");
  GONIO_CHECK(options.averaged_sites >= 1, "at least the site itself is averaged");
  if (frames.empty()) return Error{ErrorCode::kRefused, "merging exposures: there are none"};
  for (const CorrectedFrame& frame : frames) {
    const std::string difference = DifferenceOf(frames.front().format, frame.format);
    if (!difference.empty()) {
      return Error{ErrorCode::kRefused, "merging exposures: " + difference};
    }
    if (!(frame.gain() > 0) || !(frame.full > 0)) {
      return Error{ErrorCode::kRefused, "merging exposures: one has no exposure, light or range"};
    }
  }
  return Merger(frames, options).Run();
}

}  // namespace gonio
