// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/config_text.h"

#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include "core/base/printable.h"

namespace cliquevo::daemon {

namespace {

namespace fs = std::filesystem;

constexpr int kDeepest = 16;  // the configuration itself has three levels
constexpr int kMostNodes = 10'000;

struct Refused {
  int line = 0;
  std::string why;
};

class Examiner final : public YAML::EventHandler {
 public:
  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override { count(mark); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    throw Refused{mark.line + 1, "aliases (*name) are not taken: write the value itself"};
  }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t, const std::string&) override {
    count(mark);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {
    enter(mark);
  }
  void OnSequenceEnd() override { --depth_; }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {
    enter(mark);
  }
  void OnMapEnd() override { --depth_; }

 private:
  void enter(const YAML::Mark& mark) {
    count(mark);
    if (++depth_ > kDeepest) throw Refused{mark.line + 1, "too deeply nested: give sections with `key: value` lines"};
  }
  void count(const YAML::Mark& mark) {
    if (++nodes_ > kMostNodes) throw Refused{mark.line + 1, "too many values: give the keys that you change"};
  }

  int depth_ = 0;
  int nodes_ = 0;
};

}  // namespace

Result<std::string> read_config_text(const std::string& path) {
  const Error unreadable{"cannot read configuration", path, "name a YAML file that can be read"};
  std::error_code ec;
  if (!fs::is_regular_file(path, ec) && !fs::is_character_file(path, ec)) return unreadable;
  std::ifstream in(path, std::ios::binary);
  if (!in) return unreadable;
  std::string text(kLargestConfig + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (in.bad()) return unreadable;
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (text.size() <= kLargestConfig) return text;
  return Error{"cannot read configuration", path,
               fmt::format("it has more than {} kB: leave out what you do not change", kLargestConfig / 1024)};
}

Result<void> check_config_text(const std::string& text, const std::string& path) {
  try {
    std::istringstream in(text);
    YAML::Parser parser(in);
    Examiner examiner;
    parser.HandleNextDocument(examiner);
    return {};
  } catch (const Refused& refused) {
    return Error{"cannot read configuration", fmt::format("{}:{}", path, refused.line), refused.why};
  } catch (const YAML::ParserException& error) {
    return Error{"cannot read configuration", fmt::format("{}:{}", path, error.mark.line + 1),
                 fmt::format("{}; mend the YAML", error.msg)};
  } catch (const std::exception&) {
    return Error{"cannot read configuration", path, "it is no YAML: name a YAML file"};
  }
}

}  // namespace cliquevo::daemon
