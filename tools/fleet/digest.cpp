// SPDX-License-Identifier: BSD-3-Clause
#include "tools/fleet/digest.h"

#include <algorithm>
#include <elf.h>
#include <filesystem>
#include <fstream>
#include <glib.h>
#include <iterator>
#include <link.h>
#include <optional>
#include <set>
#include <system_error>

#include <fmt/format.h>

#include "drivers/video/open_video.h"

namespace cliquevo::tools::fleet {

namespace fs = std::filesystem;

struct Digest::State {
  GChecksum* sum = g_checksum_new(G_CHECKSUM_SHA256);
  State() = default;
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() { g_checksum_free(sum); }
};

Digest::Digest() : state_(std::make_unique<State>()) {}
Digest::~Digest() = default;

Digest& Digest::add(std::string_view bytes) {
  g_checksum_update(state_->sum, reinterpret_cast<const guchar*>(bytes.data()), static_cast<gssize>(bytes.size()));
  return *this;
}

Digest& Digest::field(std::string_view name, std::string_view value) {
  return add(fmt::format("{}={}:", name, value.size())).add(value).add("\n");
}

std::string Digest::hex() { return g_checksum_get_string(state_->sum); }

std::string sha256(std::string_view bytes) { return Digest().add(bytes).hex(); }

namespace {

std::string hex_of(std::string_view bytes) {
  std::string out;
  for (const char c : bytes) out += fmt::format("{:02x}", static_cast<unsigned char>(c));
  return out;
}

// The build id among an object's notes as they lie in memory; empty: it has none.
std::string build_id(const dl_phdr_info& object) {
  constexpr std::string_view kGnu("GNU\0", 4);  // with its end
  for (int k = 0; k < object.dlpi_phnum; ++k) {
    const ElfW(Phdr)& part = object.dlpi_phdr[k];
    if (part.p_type != PT_NOTE) continue;
    // The loader gives addresses as numbers. NOLINTNEXTLINE(performance-no-int-to-ptr)
    const char* at = reinterpret_cast<const char*>(object.dlpi_addr + part.p_vaddr);
    const char* end = at + part.p_memsz;
    const auto padded = [](std::size_t size) { return (size + 3) / 4 * 4; };
    while (at + sizeof(ElfW(Nhdr)) <= end) {
      const auto* note = reinterpret_cast<const ElfW(Nhdr)*>(at);
      const char* name = at + sizeof *note;
      const char* content = name + padded(note->n_namesz);
      if (note->n_type == NT_GNU_BUILD_ID && std::string_view(name, note->n_namesz) == kGnu) {
        return hex_of({content, note->n_descsz});
      }
      at = content + padded(note->n_descsz);
    }
  }
  return "";
}

std::string content_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return sha256(std::string(std::istreambuf_iterator<char>(file), {}));
}

// A line an object. The kernel's own (linux-vdso) has a build id too, and is no part of us: it has no path.
int add_object(dl_phdr_info* object, std::size_t, void* into) {
  auto& lines = *static_cast<std::set<std::string>*>(into);
  const bool program = lines.empty();  // it comes first, without a name
  const std::string path = object->dlpi_name;
  if (!program && !path.starts_with('/')) return 0;
  std::string id = build_id(*object);
  if (id.empty()) id = content_of(program ? fs::path("/proc/self/exe") : fs::path(path));
  lines.insert(fmt::format("{} {}", program ? "program" : fs::path(path).filename().string(), id));
  return 0;
}

std::string compute_build_digest() {
  std::set<std::string> lines;
  ::dl_iterate_phdr(add_object, &lines);
  std::error_code none;
  const std::string videos = drivers::video_module_path();
  if (fs::exists(videos, none)) lines.insert(fmt::format("videos {}", content_of(videos)));
  Digest digest;
  for (const std::string& line : lines) digest.field("object", line);
  return digest.hex();
}

}  // namespace

const std::string& build_digest() {
  static const std::string digest = compute_build_digest();
  return digest;
}

}  // namespace cliquevo::tools::fleet
