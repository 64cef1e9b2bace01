// SPDX-License-Identifier: BSD-3-Clause
// What the view makes of a request's head and of a page's messages: the first line of the input decides which.
#include <string>
#include <string_view>
#include <vector>

#include "tests/fuzz/expect.h"
#include "tools/view/access.h"
#include "tools/view/foxglove_protocol.h"
#include "tools/view/page_files.h"

using namespace cliquevo::view;
using cliquevo::fuzz::expect;

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  if (const auto command = parse_command(text)) expect(command->parts <= 15U, "parts are those there are");
  if (const auto request = parse_foxglove_request(text)) {
    expect(request->subscribe.size() + request->unsubscribe.size() <= kMostFoxgloveBytes, "no more than was written");
  }
  std::vector<std::string_view> lines(6);
  std::string_view rest = text;
  for (std::string_view& line : lines) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    line = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  const std::string secret = "0123456789abcdef0123456789abcdef";
  for (const std::string& token : {std::string(), secret}) {
    const AccessRules rules{8470, token, {}};
    const Judgement j = judge({lines[0], lines[1], lines[2], lines[3], lines[4], size % 2 == 0, lines[5]}, rules);
    expect(j.status == 200 || j.status == 403 || j.status == 404 || j.status == 405 || j.status == 421,
           "a known answer");
    if (j.status != 200) continue;
    expect(lines[3].empty() || lines[3].ends_with(lines[2]), "an origin is the host");
    expect(token.empty() || text.find(secret) != std::string_view::npos, "the token was there");
    const PageFile* file = find_page_file(j.path);
    expect(file == nullptr || !file->content.empty(), "a file has content");
  }
  return 0;
}
