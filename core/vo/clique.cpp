// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/clique.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace cliquevo::vo {

CliqueFinder::CliqueFinder(const StereoModel& model, const VoParams& params) : model_(model), params_(params) {
  const std::size_t n = static_cast<std::size_t>(params.max_features);
  words_ = (n + 63) / 64;
  adjacency_.resize(n * words_);
  degree_.resize(n);
  candidates_.resize(words_);
  nodes_.resize(n);
}

void CliqueFinder::build_graph(const std::vector<PointPair>& pairs) {
  const int n = static_cast<int>(pairs.size());
  const double sigma_d = params_.match_disparity_sigma_px;
  const double sigma_p = params_.match_sigma_px;
  for (int i = 0; i < n; ++i) {
    Node& node = nodes_[static_cast<std::size_t>(i)];
    const PointPair& p = pairs[static_cast<std::size_t>(i)];
    const double along_a = model_.depth_error_m(p.a.z(), sigma_d) / p.a.z();
    const double along_b = model_.depth_error_m(p.b.z(), sigma_d) / p.b.z();
    const double across_a = p.a.z() / model_.fx_px * sigma_p;
    const double across_b = p.b.z() / model_.fx_px * sigma_p;
    for (int k = 0; k < 3; ++k) {
      node.a[k] = static_cast<float>(p.a[k]);
      node.b[k] = static_cast<float>(p.b[k]);
      node.range_a[k] = static_cast<float>(p.a[k] * along_a);
      node.range_b[k] = static_cast<float>(p.b[k] * along_b);
    }
    node.lateral = static_cast<float>(across_a * across_a + across_b * across_b);
  }
  std::fill(adjacency_.begin(), adjacency_.begin() + static_cast<std::ptrdiff_t>(words_) * n, 0);
  std::fill(degree_.begin(), degree_.begin() + n, 0);
  const bool range_aware = params_.consistency == Consistency::range_aware;
  const float floor2 = static_cast<float>(params_.consistency_delta_m * params_.consistency_delta_m);
  const float sigmas2 = static_cast<float>(params_.consistency_sigmas * params_.consistency_sigmas);
  for (int i = 0; i < n; ++i) {
    const Node& p = nodes_[static_cast<std::size_t>(i)];
    for (int j = i + 1; j < n; ++j) {
      const Node& q = nodes_[static_cast<std::size_t>(j)];
      float la2 = 0, lb2 = 0, pa = 0, qa = 0, pb = 0, qb = 0;
      for (int k = 0; k < 3; ++k) {
        const float ea = p.a[k] - q.a[k];
        const float eb = p.b[k] - q.b[k];
        la2 += ea * ea;
        lb2 += eb * eb;
        pa += ea * p.range_a[k];
        qa += ea * q.range_a[k];
        pb += eb * p.range_b[k];
        qb += eb * q.range_b[k];
      }
      const float la = std::sqrt(la2);
      const float lb = std::sqrt(lb2);
      const float difference = la - lb;
      float allowed = floor2;
      if (range_aware && la > 0 && lb > 0) {
        // First-order variance of both lengths from the range errors along the rays and the position errors across.
        const float variance = (pa * pa + qa * qa) / la2 + (pb * pb + qb * qb) / lb2 + p.lateral + q.lateral;
        allowed = std::max(allowed, sigmas2 * variance);
      }
      if (difference * difference > allowed) continue;
      adjacency_[static_cast<std::size_t>(i) * words_ + static_cast<std::size_t>(j) / 64] |= 1ULL << (j % 64);
      adjacency_[static_cast<std::size_t>(j) * words_ + static_cast<std::size_t>(i) / 64] |= 1ULL << (i % 64);
      ++degree_[static_cast<std::size_t>(i)];
      ++degree_[static_cast<std::size_t>(j)];
    }
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
