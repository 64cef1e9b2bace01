// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view/access.h"

#include <algorithm>
#include <arpa/inet.h>
#include <charconv>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tools/view/foxglove_protocol.h"

namespace cliquevo::view {

namespace {

bool is_address(std::string_view text, int family) {
  char bytes[sizeof(in6_addr)];
  return text.size() < INET6_ADDRSTRLEN && inet_pton(family, std::string(text).c_str(), bytes) == 1;
}

// "127.0.0.1:8470", "[::1]:8470", "localhost:8470"
bool names_us(std::string_view host, const AccessRules& rules) {
  const std::string port = fmt::format(":{}", rules.port);
  if (host.size() <= port.size() || host.substr(host.size() - port.size()) != port) return false;
  host.remove_suffix(port.size());
  if (host == "localhost" || is_address(host, AF_INET)) return true;
  return host.size() > 2 && host.front() == '[' && host.back() == ']' &&
         is_address(host.substr(1, host.size() - 2), AF_INET6);
}

// In a time that does not depend on how much of it is right.
bool same_secret(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    difference |= static_cast<unsigned>(static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]));
  }
  return difference == 0;
}

// The value of `name` in "a=1; b=2" or "a=1&b=2"; empty = not there.
std::string_view value_of(std::string_view name, std::string_view text, char separator) {
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(separator), text.size());
    std::string_view part = text.substr(0, end);
    while (!part.empty() && part.front() == ' ') part.remove_prefix(1);
    if (part.size() > name.size() && part.substr(0, name.size()) == name && part[name.size()] == '=') {
      return part.substr(name.size() + 1);
    }
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return {};
}

}  // namespace

std::string cookie_name(const AccessRules& rules) { return fmt::format("cliquevo_{}", rules.port); }

Judgement judge(const RequestHead& request, const AccessRules& rules) {
  const auto refused = [](int status) { return Judgement{status, {}, false, false}; };
  if (!names_us(request.host, rules)) return refused(421);
  const std::size_t question = std::min(request.target.find('?'), request.target.size());
  Judgement out{200, std::string(request.target.substr(0, question)), false, false};
  out.viewer = request.upgrade && out.path == "/" && offers_foxglove(request.protocols);
  const bool invited = out.viewer && std::find(rules.viewer_origins.begin(), rules.viewer_origins.end(),
                                               request.origin) != rules.viewer_origins.end();
  if (!request.origin.empty() && !invited && request.origin != fmt::format("http://{}", request.host)) {
    return refused(403);
  }
  if (request.method != "GET" && request.method != "HEAD") return refused(405);
  if (!rules.token.empty()) {
    const std::string_view query = request.target.substr(std::min(question + 1, request.target.size()));
    const bool in_address = same_secret(value_of("token", query, '&'), rules.token);
    const bool in_cookie = same_secret(value_of(cookie_name(rules), request.cookie, ';'), rules.token);
    if (!in_address && !in_cookie) return refused(403);
    out.set_cookie = in_address;
  }
  if (request.upgrade && !out.viewer && out.path != "/live") return refused(404);
  return out;
}

std::optional<PageCommand> parse_command(std::string_view text) {
  if (text.size() > kMostCommandBytes) return std::nullopt;
  const auto message = nlohmann::json::parse(text, nullptr, false);
  if (!message.is_object()) return std::nullopt;
  const auto op = message.find("op");
  if (op == message.end() || !op->is_string()) return std::nullopt;
  using What = PageCommand::What;
  static constexpr std::pair<const char*, What> kPlain[] = {{"record-start", What::record_start},
                                                            {"record-stop", What::record_stop},
                                                            {"take-view", What::take_view},
                                                            {"drop-view", What::drop_view},
                                                            {"finish", What::finish}};
  for (const auto& [name, what] : kPlain) {
    if (*op == name) return PageCommand{what};
  }
  if (*op != "frame") return std::nullopt;
  const auto number = message.find("n");
  const auto parts = message.find("parts");
  if (number == message.end() || parts == message.end() || !number->is_number_integer() ||
      !parts->is_number_unsigned()) {
    return std::nullopt;
  }
  const auto have = message.find("have");
  const std::int64_t had = have != message.end() && have->is_number_integer() ? have->get<std::int64_t>() : -1;
  return PageCommand{PageCommand::What::frame, number->get<std::int64_t>(), parts->get<unsigned>() & 15U, had};
}

}  // namespace cliquevo::view
