// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/clique.h"

#include <algorithm>
#include <bit>

#include "core/vo/kernels/kernels.h"

namespace cliquevo::vo {

namespace {
constexpr std::size_t kMostWords = 16;  // of 1000 features
}

CliqueFinder::CliqueFinder(const StereoModel& model, const VoParams& params) : model_(model), params_(params) {
  const std::size_t n = static_cast<std::size_t>(params.max_features);
  words_ = (n + 63) / 64;
  adjacency_.resize(n * words_);
  degree_.resize(n);
  candidates_.resize(words_);
  stride_ = (n + kGraphLanes - 1) / kGraphLanes * kGraphLanes;
  storage_.resize(stride_ * kGraphFields);
}

void CliqueFinder::build_graph(const std::vector<PointPair>& pairs) {
  const int n = static_cast<int>(pairs.size());
  const double sigma_d = params_.match_disparity_sigma_px;
  const double sigma_p = params_.match_sigma_px;
  GraphNodes nodes{};
  nodes.count = n;
  float* field[kGraphFields];
  for (std::size_t f = 0; f < kGraphFields; ++f) nodes.field[f] = field[f] = storage_.data() + f * stride_;
  for (int i = 0; i < n; ++i) {
    const PointPair& p = pairs[static_cast<std::size_t>(i)];
    const double along_a = model_.depth_error_m(p.a.z(), sigma_d) / p.a.z();
    const double along_b = model_.depth_error_m(p.b.z(), sigma_d) / p.b.z();
    const double across_a = p.a.z() / model_.fx_px * sigma_p;
    const double across_b = p.b.z() / model_.fx_px * sigma_p;
    for (int k = 0; k < 3; ++k) {
      field[kAx + k][i] = static_cast<float>(p.a[k]);
      field[kBx + k][i] = static_cast<float>(p.b[k]);
      field[kRangeAx + k][i] = static_cast<float>(p.a[k] * along_a);
      field[kRangeBx + k][i] = static_cast<float>(p.b[k] * along_b);
    }
    field[kLateral][i] = static_cast<float>(across_a * across_a + across_b * across_b);
  }
  GraphTest test{};
  test.least2 = static_cast<float>(params_.consistency_delta_m * params_.consistency_delta_m);
  if (params_.consistency == Consistency::range_aware) {
    test.sigmas2 = static_cast<float>(params_.consistency_sigmas * params_.consistency_sigmas);
  }
  std::fill(adjacency_.begin(), adjacency_.begin() + static_cast<std::ptrdiff_t>(words_) * n, 0);
  const Kernels& k = kernels();
  std::uint8_t bytes[sizeof(std::uint64_t) * kMostWords] = {};
  for (int i = 0; i < n; ++i) {
    k.graph_row(nodes, i, test, bytes);
    std::uint64_t* words = &adjacency_[static_cast<std::size_t>(i) * words_];
    int degree = 0;
    for (std::size_t w = 0; w < words_; ++w) {
      for (std::size_t b = 0; b < 8; ++b) words[w] |= std::uint64_t{bytes[8 * w + b]} << (8 * b);
      if (w == static_cast<std::size_t>(i) / 64) words[w] &= ~(1ULL << (i % 64));  // no node is its own neighbour
      degree += std::popcount(words[w]);
    }
    degree_[static_cast<std::size_t>(i)] = degree;
  }
}

void CliqueFinder::grow(int count, std::vector<std::uint64_t>& allowed, std::vector<int>& clique) {
  clique.clear();
  const std::size_t words = (static_cast<std::size_t>(count) + 63) / 64;
  for (;;) {
    int best = -1;
    for (std::size_t w = 0; w < words; ++w) {
      for (std::uint64_t bits = allowed[w]; bits != 0; bits &= bits - 1) {
        const int i = static_cast<int>(w) * 64 + std::countr_zero(bits);
        if (best < 0 || degree_[static_cast<std::size_t>(i)] > degree_[static_cast<std::size_t>(best)]) best = i;
      }
    }
    if (best < 0) return;
    clique.push_back(best);
    const std::uint64_t* neighbours = row(best);
    for (std::size_t w = 0; w < words; ++w) allowed[w] &= neighbours[w];  // no node is its own neighbour
  }
}

void CliqueFinder::find(const std::vector<PointPair>& pairs, std::vector<int>& clique) {
  build_graph(pairs);
  const int n = static_cast<int>(pairs.size());
  std::fill(candidates_.begin(), candidates_.end(), 0);
  for (int i = 0; i < n; ++i) candidates_[static_cast<std::size_t>(i) / 64] |= 1ULL << (i % 64);
  grow(n, candidates_, clique);
}

void CliqueFinder::among(int count, const std::vector<int>& allowed, std::vector<int>& clique) {
  std::fill(candidates_.begin(), candidates_.end(), 0);
  for (const int i : allowed) candidates_[static_cast<std::size_t>(i) / 64] |= 1ULL << (i % 64);
  grow(count, candidates_, clique);
}

}  // namespace cliquevo::vo
