// SPDX-License-Identifier: BSD-3-Clause
// How every room chooses its SIMD kernels: a plain table of named function pointers, which the reference fills and each
// instruction set overrides, by name, where it does better.
#pragma once

#include <initializer_list>
#include <utility>
#include <vector>

#include "core/base/isa.h"

namespace cliquevo {

// What one instruction set puts into a room's table. `apply` may be compiled for that set: it runs only where the
// machine has it.
template <typename Table>
struct KernelOverrides {
  Isa isa;
  void (*apply)(Table&);
};

// A room's tables. Each set begins with the table of the one named before it, so it names only what it does better.
template <typename Table>
class KernelTables {
 public:
  KernelTables(const Table& reference, std::initializer_list<KernelOverrides<Table>> sets) {
    tables_.emplace_back(Isa::reference, reference);
    for (const KernelOverrides<Table>& set : sets) {
      if (!isa_available(set.isa)) continue;
      Table table = tables_.back().second;
      set.apply(table);
      tables_.emplace_back(set.isa, table);
    }
  }

  const Table& reference() const { return tables_.front().second; }
  // Of a set without kernels of its own: those of the one below it. nullptr: the machine lacks the set.
  const Table* find(Isa isa) const {
    if (!isa_available(isa)) return nullptr;
    const Table* found = &reference();
    for (const auto& [own, table] : tables_) {
      if (own <= isa) found = &table;
    }
    return found;
  }
  // The one in force (active_isa()).
  const Table& active() const { return *find(active_isa()); }
  // The sets with a table of their own that this machine runs, the reference first: what tests go over.
  std::vector<Isa> usable() const {
    std::vector<Isa> out;
    for (const auto& [own, table] : tables_) out.push_back(own);
    return out;
  }

 private:
  std::vector<std::pair<Isa, Table>> tables_;
};

}  // namespace cliquevo
