// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view/server.h"

#include <chrono>
#include <list>
#include <optional>
#include <random>

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>

#include "tools/view/beast.h"
#include "tools/view/foxglove_session.h"
#include "tools/view/page_files.h"
#include "tools/view/page_session.h"

namespace cliquevo::view {

namespace {

constexpr auto kTick = std::chrono::milliseconds(30);
constexpr auto kStateInterval = std::chrono::milliseconds(150);  // the state is looked at so often
constexpr auto kPatience = std::chrono::seconds(10);  // for a request to come in whole, and an answer to go out
constexpr std::size_t kMostPages = 32;                // and viewers
constexpr std::size_t kMostConnections = 96;
constexpr std::uint32_t kMostHeadBytes = 8192;
constexpr const char* kMetricsPath = "/metrics";
// No other place may give the page anything, and nobody may frame it.
constexpr const char* kPolicy =
    "default-src 'self'; connect-src 'self'; img-src 'self' blob: data:; style-src 'self' 'unsafe-inline'; "
    "frame-ancestors 'none'; base-uri 'none'; form-action 'none'";

std::string view_of(const HttpRequest& request, http::field field) {
  const auto found = request.find(field);
  return found == request.end() ? std::string() : std::string(found->value());
}

std::string random_token() {
  std::random_device source;
  std::string out;
  for (int i = 0; i < 4; ++i) {
    char part[9];
    std::snprintf(part, sizeof part, "%08x", static_cast<unsigned>(source()));
    out += part;
  }
  return out;
}

class BeastServer;

// One connection until it ends or becomes a page's WebSocket.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(Tcp::socket&& socket, BeastServer& server);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  void read();

 private:
  void answer();
  void reply(int status, const Judgement& judgement, const PageFile* file);

  std::string metrics_;  // stays until it has been sent
  beast::tcp_stream stream_;
  BeastServer& server_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::empty_body>> parser_;
  http::response<http::span_body<const char>> response_;
};

class BeastServer final : public Server {
 public:
  BeastServer(const Store& store, Ros2Topics& topics, PageContent content)
      : store_(store), topics_(topics), content_(std::move(content)), acceptor_(io_) {}

  Result<void> listen(const ServerOptions& options);
  std::string address() const override;
  void run(const std::function<bool()>& stopped) override;

  bool start_session(beast::tcp_stream&& stream, const HttpRequest& request, bool viewer);
  const AccessRules& rules() const { return rules_; }
  std::string metrics() const { return content_.metrics(); }
  std::size_t connections = 0;

 private:
  void accept();
  void tick(const std::function<bool()>& stopped);
  void update_shared();

  asio::io_context io_{1};
  const Store& store_;
  Ros2Topics& topics_;
  std::string version_;
  const PageContent content_;
  Tcp::acceptor acceptor_;
  asio::steady_timer timer_{io_};
  asio::steady_timer pause_{io_};
  AccessRules rules_;
  SharedState shared_;
  std::chrono::steady_clock::time_point shared_at_;
  std::list<std::shared_ptr<Session>> sessions_;  // last: they look at the others
};

Connection::Connection(Tcp::socket&& socket, BeastServer& server) : stream_(std::move(socket)), server_(server) {
  ++server_.connections;
}
Connection::~Connection() { --server_.connections; }

void Connection::read() {
  parser_.emplace();
  parser_->header_limit(kMostHeadBytes);
  parser_->body_limit(0);
  stream_.expires_after(kPatience);
  http::async_read(stream_, buffer_, *parser_, [self = shared_from_this()](beast::error_code error, std::size_t) {
    if (error == http::error::end_of_stream) {
      beast::error_code ignored;
      self->stream_.socket().shutdown(Tcp::socket::shutdown_send, ignored);
    } else if (error && error.category() == http::make_error_code(http::error::bad_method).category()) {
      self->reply(400, {}, nullptr);
    } else if (!error) {
      self->answer();
    }
  });
}

void Connection::answer() {
  const HttpRequest& request = parser_->get();
  const bool upgrade = asks_for_web_socket(request);
  const std::string method(request.method_string());
  const std::string target(request.target());
  const std::string host = view_of(request, http::field::host);
  const std::string origin = view_of(request, http::field::origin);
  const std::string cookie = view_of(request, http::field::cookie);
  const std::string protocols = view_of(request, http::field::sec_websocket_protocol);
  const Judgement judgement = judge({method, target, host, origin, cookie, upgrade, protocols}, server_.rules());
  if (judgement.status != 200) return reply(judgement.status, judgement, nullptr);
  if (upgrade) {
    if (!server_.start_session(std::move(stream_), request, judgement.viewer)) reply(503, judgement, nullptr);
    return;
  }
  if (judgement.path == kMetricsPath) {
    metrics_ = server_.metrics();
    const PageFile page{kMetricsPath, "text/plain; version=0.0.4; charset=utf-8", metrics_};
    return reply(200, judgement, &page);
  }
  const PageFile* file = find_page_file(judgement.path);
  reply(file != nullptr ? 200 : 404, judgement, file);
}

void Connection::reply(int status, const Judgement& judgement, const PageFile* file) {
  response_ = {};
  response_.result(static_cast<unsigned>(status));
  response_.version(11);
  const bool keep = file != nullptr && parser_->get().keep_alive();
  response_.keep_alive(keep);
  response_.set("Content-Security-Policy", kPolicy);
  response_.set("X-Content-Type-Options", "nosniff");
  response_.set("Referrer-Policy", "no-referrer");
  response_.set("Cross-Origin-Resource-Policy", "same-origin");
  response_.set(http::field::cache_control, "no-store");
  static constexpr std::string_view kRefused = "cliquevo view: not served\n";
  const std::string_view body = file != nullptr ? file->content : kRefused;
  response_.set(http::field::content_type, file != nullptr ? beast::string_view(file->type.data(), file->type.size())
                                                           : beast::string_view("text/plain"));
  if (judgement.set_cookie) {
    response_.set(http::field::set_cookie,
                  cookie_name(server_.rules()) + "=" + server_.rules().token + "; HttpOnly; SameSite=Strict; Path=/");
  }
  response_.content_length(body.size());
  if (parser_->get().method() != http::verb::head) response_.body() = {body.data(), body.size()};
  stream_.expires_after(kPatience);
  http::async_write(stream_, response_, [self = shared_from_this(), keep](beast::error_code error, std::size_t) {
    if (error) return;
    if (keep) return self->read();
    beast::error_code ignored;
    self->stream_.socket().shutdown(Tcp::socket::shutdown_send, ignored);
  });
}

Result<void> BeastServer::listen(const ServerOptions& options) {
  const auto failed = [&options](const beast::error_code& error, const char* remedy) {
    return Error{"cannot serve the page", options.listen + " port " + std::to_string(options.port),
                 error.message() + "; " + remedy};
  };
  beast::error_code error;
  const auto address = asio::ip::make_address(options.listen, error);
  if (error) return failed(error, "--listen takes an address of this machine in numbers");
  const Tcp::endpoint endpoint(address, options.port);
  acceptor_.open(endpoint.protocol(), error);
  if (!error) acceptor_.set_option(asio::socket_base::reuse_address(true), error);
  if (!error) acceptor_.bind(endpoint, error);
  if (!error) acceptor_.listen(asio::socket_base::max_listen_connections, error);
  if (error) return failed(error, "choose another with --port, or 0 for any that is free");
  version_ = options.version;
  rules_.viewer_origins = options.viewer_origins;
  rules_.port = acceptor_.local_endpoint().port();
  if (!address.is_loopback()) rules_.token = random_token();
  accept();
  return {};
}

std::string BeastServer::address() const {
  const auto at = acceptor_.local_endpoint().address();
  const std::string host = at.is_unspecified() ? "127.0.0.1" : at.is_v6() ? "[" + at.to_string() + "]" : at.to_string();
  const std::string query = rules_.token.empty() ? "" : "?token=" + rules_.token;
  return "http://" + host + ":" + std::to_string(rules_.port) + "/" + query;
}

void BeastServer::accept() {
  acceptor_.async_accept([this](beast::error_code error, Tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (error) {  // out of file descriptors: those that are there may end
      pause_.expires_after(std::chrono::milliseconds(200));
      pause_.async_wait([this](beast::error_code stopped) {
        if (!stopped) accept();
      });
      return;
    }
    if (connections + sessions_.size() < kMostConnections) {
      beast::error_code ignored;
      socket.set_option(Tcp::no_delay(true), ignored);
      std::make_shared<Connection>(std::move(socket), *this)->read();
    }
    accept();
  });
}

bool BeastServer::start_session(beast::tcp_stream&& stream, const HttpRequest& request, bool viewer) {
  if (sessions_.size() >= kMostPages) return false;
  update_shared();
  if (viewer) {
    auto socket = make_web_socket(std::move(stream), request, kMostFoxgloveBytes, kFoxgloveProtocol);
    sessions_.push_back(std::make_shared<FoxgloveSession>(std::move(socket), topics_, version_));
  } else {
    auto socket = make_web_socket(std::move(stream), request, kMostCommandBytes, "");
    sessions_.push_back(std::make_shared<PageSession>(std::move(socket), store_, content_, shared_));
  }
  sessions_.back()->start();
  return true;
}

// The same text stays the same object: pages that have it get nothing.
void BeastServer::update_shared() {
  shared_at_ = std::chrono::steady_clock::now();
  std::string state = content_.state();
  if (!shared_.state || *shared_.state != state) shared_.state = std::make_shared<const std::string>(std::move(state));
  shared_.mask = content_.mask();
}

void BeastServer::tick(const std::function<bool()>& stopped) {
  if (stopped()) return io_.stop();
  sessions_.remove_if([](const auto& session) { return session->open() ? false : session.use_count() == 1; });
  if (!sessions_.empty() && std::chrono::steady_clock::now() - shared_at_ >= kStateInterval) update_shared();
  for (const auto& session : sessions_) session->pump();
  timer_.expires_after(kTick);
  timer_.async_wait([this, &stopped](beast::error_code error) {
    if (!error) tick(stopped);
  });
}

void BeastServer::run(const std::function<bool()>& stopped) {
  tick(stopped);
  io_.run();
}

}  // namespace

Result<std::unique_ptr<Server>> Server::open(const ServerOptions& options, const Store& store, Ros2Topics& topics,
                                             PageContent content) {
  auto server = std::make_unique<BeastServer>(store, topics, std::move(content));
  if (auto ok = server->listen(options); !ok) return ok.error();
  return std::unique_ptr<Server>(std::move(server));
}

}  // namespace cliquevo::view
