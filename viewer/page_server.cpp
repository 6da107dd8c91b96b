#include "viewer/page_server.h"

#include <httplib.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>

#include <nlohmann/json.hpp>

#include "tool/error.h"
#include "tool/parallel_for.h"
#include "viewer/page.h"

namespace nlg {
namespace {

constexpr const char* kAddress = "127.0.0.1";
constexpr int kClients = 16;                    // at once
constexpr size_t kMostRequestBytes = 32 << 10;  // whoever sends more has nothing to ask for here
constexpr auto kMostAsking = std::chrono::seconds(2), kMostAnswering = std::chrono::seconds(30);

// One request of one client, and no longer than that takes: what comes in drips counts as a whole.
class Client : public httplib::Stream {
 public:
  Client(socket_t socket, const std::atomic<bool>& is_ended) : socket_(socket), is_ended_(is_ended) {}

  bool is_readable() const override { return waitFor(POLLIN, kMostAsking); }
  bool is_writable() const override { return waitFor(POLLOUT, kMostAnswering); }
  ssize_t read(char* to, size_t count) override {
    if (bytes_left_ == 0 || !is_readable()) return -1;
    const ssize_t got = ::recv(socket_, to, std::min(count, bytes_left_), 0);
    bytes_left_ -= static_cast<size_t>(std::max<ssize_t>(0, got));
    return got;
  }
  ssize_t write(const char* from, size_t count) override {
    return is_writable() ? ::send(socket_, from, count, MSG_NOSIGNAL | MSG_DONTWAIT) : -1;
  }
  void get_remote_ip_and_port(std::string& ip, int& port) const override { ip = kAddress, port = 0; }
  void get_local_ip_and_port(std::string& ip, int& port) const override { ip = kAddress, port = 0; }
  socket_t socket() const override { return socket_; }

 private:
  bool waitFor(short what, std::chrono::seconds most) const {
    constexpr int kLookEveryMs = 50;
    while (!is_ended_ && std::chrono::steady_clock::now() < begin_ + most) {
      pollfd polled{socket_, what, 0};
      if (::poll(&polled, 1, kLookEveryMs) > 0) return true;
    }
    return false;
  }

  const socket_t socket_;
  const std::atomic<bool>& is_ended_;
  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  size_t bytes_left_ = kMostRequestBytes;
};

void answer(httplib::Response* response, int status, const std::string& text, const char* kind = "text/plain") {
  response->status = status;
  response->set_content(text, kind);
}

std::string servedPage(std::string page) {
  const std::string html = "<html ";
  page.insert(page.find(html) + html.size(), "data-served=\"1\" ");
  return page;
}

}  // namespace

class PageServer::Server : public httplib::Server {
 public:
  void end() {
    is_ended_ = true;
    stop();
  }

 private:
  bool process_and_close_socket(socket_t socket) override {
    Client client(socket, is_ended_);
    bool is_closed = false;
    // parts of scripts nobody needs, and many parts of one are more than it has
    const bool is_done = process_request(client, true, is_closed, [](httplib::Request& request) { request.ranges.clear(); });
    ::shutdown(socket, SHUT_RDWR);
    ::close(socket);
    return is_done;
  }

  std::atomic<bool> is_ended_ = false;
};

PageServer::PageServer(int port)
    : server_(std::make_unique<Server>()),
      shown_(static_cast<uint64_t>(std::chrono::system_clock::now().time_since_epoch() / std::chrono::milliseconds(1))) {
  // the library's own way lets two servers share a port, so that a browser reaches now one, now the other
  server_->set_socket_options([](socket_t socket) {
    const int yes = 1;
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  port_ = port == 0 ? server_->bind_to_any_port(kAddress) : server_->bind_to_port(kAddress, port) ? port : -1;
  if (port_ < 0) throw UsageError("--port", "a free port, or 0 for any", std::to_string(port));
  server_->set_payload_max_length(0);  // nobody has anything to send
  server_->new_task_queue = [] { return new httplib::ThreadPool(kClients); };
  server_->set_default_headers({{"Cache-Control", "no-store"},
                                {"Content-Security-Policy", "frame-ancestors 'none'"},
                                {"Cross-Origin-Resource-Policy", "same-origin"}});
  server_->set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
    const std::string host = request.get_header_value("Host"), port_text = ":" + std::to_string(port_);
    if (host == kAddress + port_text || host == "localhost" + port_text) return httplib::Server::HandlerResponse::Unhandled;
    answer(&response, 403, "This server answers to " + url() + " only.\n");
    return httplib::Server::HandlerResponse::Handled;
  });
  addPage();
  server_->Get("/state", [this](const httplib::Request&, httplib::Response& response) {
    const std::lock_guard lock(mutex_);
    const nlohmann::ordered_json state = {{"shown", scripts_.empty() ? 0 : shown_},
                                          {"text", text_},
                                          {"failed", mood_ == Mood::failed},
                                          {"busy", mood_ == Mood::busy},
                                          {"stage", stage_.name},
                                          {"share", stage_.share ? nlohmann::ordered_json(*stage_.share) : nullptr}};
    answer(&response, 200, state.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace), "application/json");
  });
  server_->Get(R"(/([\w-]+\.js))", [this](const httplib::Request& request, httplib::Response& response) {
    const std::lock_guard lock(mutex_);
    const auto script = scripts_.find(request.matches[1]);
    const bool is_shown = request.has_param(std::to_string(shown_));
    if (script == scripts_.end() || !is_shown) return answer(&response, 404, "no such script by now\n");
    answer(&response, 200, script->second, "text/javascript");
  });
  thread_ = startThread([this] { server_->listen_after_bind(); });
  // stop() would pass by one that has not begun
  while (!server_->is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

PageServer::~PageServer() {
  server_->end();
  thread_.join();
}

void PageServer::addPage() {
  for (const PageFile& file : pageFiles()) {
    const bool is_page = file.name == "index.html";
    const std::string text = is_page ? servedPage(std::string(file.text)) : std::string(file.text);
    server_->Get(is_page ? "/" : "/" + std::string(file.name), [=](const httplib::Request&, httplib::Response& response) {
      answer(&response, 200, text, is_page ? "text/html" : "text/javascript");
    });
  }
}

void PageServer::show(std::map<std::string, std::string> scripts) {
  const std::lock_guard lock(mutex_);
  scripts_ = std::move(scripts);
  ++shown_;
}

void PageServer::tell(const std::string& text, Mood mood) {
  const std::lock_guard lock(mutex_);
  text_ = text;
  mood_ = mood;
  stage_ = {};
}

void PageServer::tellStage(const Stage& stage) {
  const std::lock_guard lock(mutex_);
  stage_ = stage;
}

}  // namespace nlg
