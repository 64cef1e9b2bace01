// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/lcm/tcpq_client.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <future>
#include <mutex>
#include <netdb.h>
#include <optional>
#include <poll.h>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

#include "core/base/time.h"
#include "daemon/lcm/lcm_url.h"

namespace cliquevo::daemon {

namespace {

constexpr std::int64_t kMillisecondNs = 1'000'000;
constexpr std::chrono::milliseconds kNamePatience{500};     // for the name server
constexpr std::int64_t kGreetingNs = 500 * kMillisecondNs;  // less than the watchdog's patience
constexpr std::int64_t kSlowNs = 50 * kMillisecondNs;       // waited for a server that reads slowly
constexpr std::int64_t kFarewellNs = 500 * kMillisecondNs;
constexpr std::int64_t kRetryNs = 1'000 * kMillisecondNs;
constexpr std::size_t kMostWaiting = std::size_t{1} << 20;  // bytes for a server that does not read

constexpr std::uint32_t kServerMagic = 0x287617fa;
constexpr std::uint32_t kClientMagic = 0x287617fb;
constexpr std::uint32_t kVersion = 0x0100;
constexpr std::uint32_t kPublish = 1;

void put(std::vector<std::uint8_t>& out, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) out.push_back(static_cast<std::uint8_t>(value >> shift));
}

// What getaddrinfo() found: its error, or the address.
struct Resolved {
  int error = 0;
  sockaddr_in address{};
};

Resolved ask_name_server(const ServerUrl& server, int flags) {
  addrinfo hints{};
  hints.ai_flags = flags;
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  Resolved out;
  out.error = ::getaddrinfo(server.host.c_str(), std::to_string(server.port).c_str(), &hints, &found);
  if (out.error != 0) return out;
  std::memcpy(&out.address, found->ai_addr, sizeof out.address);
  ::freeaddrinfo(found);
  return out;
}

// A name server that does not answer blocks the caller for half a minute, and the call cannot be cancelled: it runs on
// a detached thread, one at a time. Nothing: no answer yet; a later call for the same name returns it.
std::optional<Resolved> resolve(const ServerUrl& server) {
  if (const Resolved plain = ask_name_server(server, AI_NUMERICHOST); plain.error == 0) return plain;
  static std::mutex mutex;
  static std::string looked_up;  // host and port
  static std::shared_future<Resolved> answer;
  const std::lock_guard<std::mutex> lock(mutex);
  const std::string name = server.host + ":" + std::to_string(server.port);
  if (!answer.valid() || looked_up != name) {
    std::promise<Resolved> promise;
    answer = promise.get_future().share();
    looked_up = name;
    std::thread([server, promise = std::move(promise)]() mutable {
      promise.set_value(ask_name_server(server, 0));
    }).detach();
  }
  if (answer.wait_for(kNamePatience) != std::future_status::ready) return std::nullopt;
  return std::exchange(answer, {}).get();
}

}  // namespace

struct TcpqClient::Impl {
  enum class State { down, connecting, greeting, ready };

  ~Impl() { close(); }
  void close() {
    if (fd >= 0) ::close(std::exchange(fd, -1));
    state = State::down;
    waiting.clear();
    next_try_ns = monotonic_ns() + kRetryNs;
  }

  void connect() {
    fd = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    greeting_size = 0;
    deadline_ns = monotonic_ns() + kGreetingNs;
    state = State::connecting;
    const bool failed = fd < 0 || (::connect(fd, reinterpret_cast<const sockaddr*>(&server), sizeof server) != 0 &&
                                   errno != EINPROGRESS);
    if (failed) lose("no LCM server", errno);
  }
  void lose(const std::string& what, int error) {
    problem = error != 0 ? what + " (" + std::strerror(error) + ")" : what;
    close();
  }
  // Does what can be done without waiting for the server.
  void advance() {
    if (state == State::down && monotonic_ns() >= next_try_ns) connect();
    if (state == State::connecting) finish_connecting();
    if (state == State::greeting) read_greeting();
    if ((state == State::connecting || state == State::greeting) && monotonic_ns() > deadline_ns) {
      lose("the LCM server does not answer", 0);
    }
    if (state == State::ready) flush();
  }
  void finish_connecting() {
    pollfd writable{fd, POLLOUT, 0};
    if (::poll(&writable, 1, 0) <= 0) return;
    int error = 0;
    socklen_t size = sizeof error;
    ::getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &size);
    if (error != 0) return lose("no LCM server", error);
    std::vector<std::uint8_t> hello;
    put(hello, kClientMagic);
    put(hello, kVersion);
    if (::send(fd, hello.data(), hello.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(hello.size())) {
      return lose("the LCM server does not read", errno);
    }
    state = State::greeting;
  }
  void read_greeting() {
    const ssize_t got = ::recv(fd, &greeting[greeting_size], greeting.size() - greeting_size, 0);
    if (got < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (got <= 0) return lose("the LCM server hung up", got < 0 ? errno : 0);
    greeting_size += static_cast<std::size_t>(got);
    if (greeting_size < greeting.size()) return;
    std::vector<std::uint8_t> expected;
    put(expected, kServerMagic);
    if (!std::equal(expected.begin(), expected.end(), greeting.begin())) return lose("this is no LCM server", 0);
    state = State::ready;
    stands_still = false;
  }
  void flush() {
    std::size_t sent = 0;
    while (sent < waiting.size()) {
      const ssize_t n = ::send(fd, &waiting[sent], waiting.size() - sent, MSG_NOSIGNAL);
      if (n < 0 && errno == EINTR) continue;
      if (n < 0 && errno == EAGAIN) break;
      if (n <= 0) return lose("the LCM server hung up", errno);
      sent += static_cast<std::size_t>(n);
    }
    waiting.erase(waiting.begin(), waiting.begin() + static_cast<std::ptrdiff_t>(sent));
    if (sent > 0) stands_still = false;
  }
  // Until done() or for so long.
  template <typename Done>
  bool wait(std::int64_t patience_ns, const Done& done) {
    const std::int64_t end_ns = monotonic_ns() + patience_ns;
    for (;;) {
      advance();
      if (done()) return true;
      const std::int64_t left_ns = end_ns - monotonic_ns();
      if (state == State::down || left_ns <= 0) return false;
      pollfd ready{fd, static_cast<short>(state == State::greeting ? POLLIN : POLLOUT), 0};
      ::poll(&ready, 1, static_cast<int>(left_ns / kMillisecondNs) + 1);
    }
  }

  sockaddr_in server{};
  State state = State::down;
  int fd = -1;
  std::int64_t deadline_ns = 0;  // of connecting and greeting
  std::int64_t next_try_ns = 0;
  std::array<std::uint8_t, 8> greeting{};  // magic, version
  std::size_t greeting_size = 0;
  std::vector<std::uint8_t> waiting;  // what the kernel has not taken yet
  bool stands_still = false;          // the last wait for the server was in vain
  std::string problem;                // why the connection was lost
  std::mutex mutex;
};

Result<std::unique_ptr<TcpqClient>> TcpqClient::open(const std::string& url) {
  const auto address = parse_server_url(url);
  if (!address) return address.error();
  const auto resolved = resolve(*address);
  if (!resolved) {
    return Error{"the LCM server's name is not known yet: the name server does not answer", url,
                 "write the server's address in place of its name, or see to the name server"};
  }
  if (resolved->error != 0) return Error{"unknown host in the LCM URL", url, ::gai_strerror(resolved->error)};
  auto impl = std::make_unique<Impl>();
  impl->server = resolved->address;
  const bool ready = impl->wait(kGreetingNs, [&] { return impl->state == Impl::State::ready; });
  if (!ready) {
    if (impl->problem.empty()) impl->problem = "the LCM server does not answer";
    return Error{impl->problem, url, "start lcm-tcpq-server there"};
  }
  return std::unique_ptr<TcpqClient>(new TcpqClient(std::move(impl)));
}

bool TcpqClient::send(const std::string& channel, const std::uint8_t* data, std::size_t size) {
  Impl& m = *impl_;
  const std::lock_guard<std::mutex> lock(m.mutex);
  m.advance();
  if (m.state != Impl::State::ready) return false;
  const auto has_room = [&m] { return m.waiting.size() < kMostWaiting; };
  if (!has_room()) {
    const bool waited = !m.stands_still && m.wait(kSlowNs, has_room);
    if (m.state != Impl::State::ready) return false;
    if (!waited) {
      m.stands_still = true;
      return false;
    }
  }
  put(m.waiting, kPublish);
  put(m.waiting, static_cast<std::uint32_t>(channel.size()));
  m.waiting.insert(m.waiting.end(), channel.begin(), channel.end());
  put(m.waiting, static_cast<std::uint32_t>(size));
  m.waiting.insert(m.waiting.end(), data, data + size);
  m.advance();
  return m.state == Impl::State::ready;
}

TcpqClient::TcpqClient(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TcpqClient::~TcpqClient() {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  if (impl_->state == Impl::State::ready && !impl_->stands_still) {
    impl_->wait(kFarewellNs, [this] { return impl_->waiting.empty(); });
  }
}

}  // namespace cliquevo::daemon
