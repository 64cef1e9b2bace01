// SPDX-License-Identifier: BSD-3-Clause
#include "tools/spy.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <unistd.h>
#include <vector>

#include <fmt/format.h>

#include "core/base/result.h"
#include "daemon/pipeline/config.h"
#include "tools/exit_code.h"

namespace cliquevo::tools {

namespace {

namespace fs = std::filesystem;

// What Debian's packages bring; its own lcm-spy script gives Java options that Java 17 no longer knows.
constexpr const char* kLcmJar = "/usr/share/java/lcm.jar";
constexpr const char* kChartJar = "/usr/share/java/jchart2d.jar";
constexpr const char* kPackages = "apt-get install liblcm-java libjchart2d-java default-jdk";

struct SpyOptions {
  std::string url = daemon::LcmConfig{}.url;
  std::string types;
};

// The .lcm files: beside the installed program, or in the source tree whose build/PRESET/bin it is in.
std::string find_types() {
  std::error_code none;
  const fs::path program = fs::read_symlink("/proc/self/exe", none);
  for (const fs::path& folder :
       {program.parent_path() / "../share/cliquevo/lcmtypes", program.parent_path() / "../../../daemon/lcmtypes"}) {
    if (fs::is_directory(folder, none)) return folder.lexically_normal().string();
  }
  return {};
}

std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

bool has_command(const char* name) { return std::system(fmt::format("command -v {} >/dev/null", name).c_str()) == 0; }

// Generates, compiles and packs the Java classes into `dir`/types.jar. Takes two seconds, so it is done each time: the
// types are then always those of this program.
Result<std::string> make_types_jar(const std::string& types, const std::string& dir) {
  const std::string command = fmt::format(
      "cd {0} && lcm-gen --java --jpath=java {1}/*.lcm >log 2>&1 && "
      "javac -classpath {2} -d classes $(find java -name '*.java') >>log 2>&1 && jar cf types.jar -C classes . >>log "
      "2>&1",
      quoted(dir), quoted(types), kLcmJar);
  if (std::system(command.c_str()) != 0) {
    return Error{"cannot compile the message types", types, fmt::format("see {}/log; {}", dir, kPackages)};
  }
  return dir + "/types.jar";
}

Result<void> start(const SpyOptions& options) {
  for (const char* jar : {kLcmJar, kChartJar}) {
    if (!fs::exists(jar)) return Error{"lcm-spy is not installed", jar, kPackages};
  }
  for (const char* program : {"java", "javac", "jar", "lcm-gen"}) {
    if (!has_command(program)) return Error{"lcm-spy cannot start", program, std::string(kPackages) + " liblcm-bin"};
  }
  if (std::getenv("DISPLAY") == nullptr && std::getenv("WAYLAND_DISPLAY") == nullptr) {
    return Error{"no display", "DISPLAY", "run it on a desktop, or over ssh -X"};
  }
  const std::string types = options.types.empty() ? find_types() : options.types;
  if (types.empty() || !fs::is_directory(types)) {
    return Error{"no message types", types.empty() ? "(nowhere)" : types, "name the folder of .lcm files with --types"};
  }
  std::string dir = (fs::temp_directory_path() / "cliquevo-spy-XXXXXX").string();
  if (::mkdtemp(dir.data()) == nullptr) return Error{"cannot make a folder", dir, std::strerror(errno)};
  const auto jar = make_types_jar(types, dir);
  if (!jar) return jar.error();
  ::setenv("LCM_DEFAULT_URL", options.url.c_str(), 1);
  const std::string command = fmt::format("java -Djava.net.preferIPv4Stack=true -ea -cp {}:{}:{} lcm.spy.Spy", kLcmJar,
                                          kChartJar, quoted(*jar));
  const int status = std::system(command.c_str());
  std::error_code ignored;
  fs::remove_all(dir, ignored);
  if (status != 0) return Error{"lcm-spy ended with an error", "java", "see the lines above"};
  return {};
}

}  // namespace

void add_spy_command(CliCommand app, int& exit_code) {
  auto options = std::make_shared<SpyOptions>();
  const CliCommand spy = app.add_subcommand("spy", "Watch the messages: lcm-spy with every field of ours");
  spy.add_option("--lcm", options->url, "LCM URL").type_name("URL").capture_default_str();
  spy.add_option("--types", options->types, "Folder of .lcm files (default: those of this program)").type_name("DIR");
  spy.footer("Double-click a channel to see its fields. Needs a display and Java:\n  " + std::string(kPackages));
  spy.callback([options, &exit_code] {
    if (const auto ok = start(*options); !ok) exit_code = report(ok.error());
  });
}

}  // namespace cliquevo::tools
