#include "http_server.hpp"

#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/sendfile.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <list>
#include <memory>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <thread>

namespace plumbline::cli {

namespace {

using Clock = std::chrono::steady_clock;

constexpr size_t longest_head = 16 * 1024, most_connections = 64;
constexpr std::chrono::seconds time_for_head(5), time_without_progress(10), time_for_all(600);

const char* reason_of(int status) {
  switch (status) {
    case 200:
      return "OK";
    case 303:
      return "See Other";
    case 400:
      return "Bad Request";
    case 401:
      return "Unauthorized";
    case 404:
      return "Not Found";
    case 405:
      return "Method Not Allowed";
    case 408:
      return "Request Timeout";
    case 421:
      return "Misdirected Request";
    case 431:
      return "Request Header Fields Too Large";
    default:
      return "Internal Server Error";
  }
}

bool wait_for(int socket, short events, Clock::time_point until) {
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now()).count();
    if (left <= 0) return false;
    pollfd one{socket, events, 0};
    const int ready = poll(&one, 1, static_cast<int>(std::min<long long>(left, 60'000)));
    if (ready > 0) return true;
    if (ready < 0 && errno != EINTR) return false;
  }
}

/// Up to the empty line; 0 if it came, else the status to answer, or -1 for a connection that just went.
int read_head(int socket, std::string& head) {
  const auto until = Clock::now() + time_for_head;
  std::array<char, 4096> some;
  while (head.find("\r\n\r\n") == std::string::npos) {
    if (head.size() > longest_head) return 431;
    if (!wait_for(socket, POLLIN, until)) return head.empty() ? -1 : 408;
    const ssize_t count = recv(socket, some.data(), some.size(), MSG_DONTWAIT);
    if (count < 0 && (errno == EAGAIN || errno == EINTR)) continue;
    if (count <= 0) return -1;
    head.append(some.data(), static_cast<size_t>(count));
  }
  return head.find("\r\n\r\n") > longest_head ? 431 : 0;
}

/// `step` moves some bytes and returns their number.
template <typename Step>
bool move_all(int socket, std::uint64_t size, Step step) {
  const auto end = Clock::now() + time_for_all;
  for (std::uint64_t done = 0; done < size;) {
    if (!wait_for(socket, POLLOUT, std::min(end, Clock::now() + time_without_progress))) return false;
    const ssize_t count = step(done, size - done);
    if (count < 0 && (errno == EAGAIN || errno == EINTR)) continue;
    if (count <= 0) return false;  // also a file that became shorter meanwhile
    done += static_cast<std::uint64_t>(count);
  }
  return true;
}

bool send_text(int socket, const std::string& text) {
  return move_all(socket, text.size(), [&](std::uint64_t done, std::uint64_t left) {
    return send(socket, text.data() + done, left, MSG_NOSIGNAL | MSG_DONTWAIT);
  });
}

void send_answer(int socket, const HttpAnswer& answer, bool with_body) {
  const std::uint64_t size = answer.file >= 0 ? answer.size : answer.body.size();
  std::string head = "HTTP/1.1 " + std::to_string(answer.status) + " " + reason_of(answer.status) +
                     "\r\nConnection: close\r\nContent-Type: " + answer.type +
                     "\r\nContent-Length: " + std::to_string(size) + "\r\n";
  for (const auto& [name, value] : answer.headers) head += name + ": " + value + "\r\n";
  if (!send_text(socket, head + "\r\n") || !with_body) return;
  if (answer.file < 0) {
    send_text(socket, answer.body);
    return;
  }
  move_all(socket, size, [&](std::uint64_t, std::uint64_t left) {
    return sendfile(socket, answer.file, nullptr, std::min<std::uint64_t>(left, 1 << 18));
  });
}

HttpAnswer refusal(int status) {
  HttpAnswer answer;
  answer.status = status;
  answer.body = std::string(reason_of(status)) + "\n";
  if (status == 405) answer.headers.push_back({"Allow", "GET, HEAD"});
  return answer;
}

void serve(int socket, const HttpServer::Handler& handler) {
  std::string head;
  int status = read_head(socket, head);
  if (status < 0) return;
  HttpRequest request;
  HttpAnswer answer;
  if (status == 0 && parse_request(head, request, status)) {
    try {
      answer = handler(request);
    } catch (const std::exception& error) {
      answer = refusal(500);
      answer.body = std::string(error.what()) + "\n";
    }
  } else {
    answer = refusal(status);
  }
  send_answer(socket, answer, head.rfind("HEAD ", 0) != 0);
  if (answer.file >= 0) close(answer.file);
  // What the other side still sends is taken for a moment, or its own answer would be lost with a reset.
  constexpr size_t most_taken = 256 * 1024;
  shutdown(socket, SHUT_WR);
  std::array<char, 4096> some;
  const auto until = Clock::now() + std::chrono::milliseconds(500);
  for (size_t taken = 0; taken < most_taken && wait_for(socket, POLLIN, until);) {
    const ssize_t count = recv(socket, some.data(), some.size(), MSG_DONTWAIT);
    if (count <= 0) break;
    taken += static_cast<size_t>(count);
  }
}

struct Connection {
  int socket = -1;
  bool told = false;  ///< that it is to end
  std::atomic<bool> ended = false;
  std::thread thread;
};

std::string lower(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

int hex_of(char c) {
  const std::string_view digits = "0123456789abcdef";
  const size_t at = digits.find(c >= 'A' && c <= 'F' ? static_cast<char>(c - 'A' + 'a') : c);
  return at == std::string_view::npos ? -1 : static_cast<int>(at);
}

bool parse_query(const std::string& text, HttpRequest& request) {
  for (size_t at = 0; at < text.size();) {
    const size_t end = std::min(text.find('&', at), text.size()), equals = std::min(text.find('=', at), end);
    std::string name, value;
    if (!percent_decoded(text.substr(at, equals - at), true, name)) return false;
    if (equals < end && !percent_decoded(text.substr(equals + 1, end - equals - 1), true, value)) return false;
    if (!request.query.emplace(name, value).second) return false;
    at = end + 1;
  }
  return true;
}

}  // namespace

bool percent_decoded(const std::string& text, bool plus, std::string& decoded) {
  decoded.clear();
  for (size_t i = 0; i < text.size(); ++i) {
    char c = text[i];
    if (c == '%') {
      if (i + 2 >= text.size() || hex_of(text[i + 1]) < 0 || hex_of(text[i + 2]) < 0) return false;
      c = static_cast<char>(16 * hex_of(text[i + 1]) + hex_of(text[i + 2]));
      i += 2;
    } else if (c == '+' && plus) {
      c = ' ';
    }
    if (c == '\0') return false;
    decoded += c;
  }
  return true;
}

bool parse_request(const std::string& head, HttpRequest& request, int& status) {
  status = 400;
  const size_t end = head.find("\r\n");
  const std::string first = head.substr(0, end);
  const size_t space = first.find(' '), second = first.find(' ', space + 1);
  if (end == std::string::npos || space == std::string::npos || second == std::string::npos) return false;
  const std::string version = first.substr(second + 1);
  if (version != "HTTP/1.1" && version != "HTTP/1.0") return false;
  if (const std::string method = first.substr(0, space); method != "GET" && method != "HEAD") {
    status = 405;
    return false;
  }
  const std::string target = first.substr(space + 1, second - space - 1);
  const size_t mark = std::min(target.find('?'), target.size());
  if (target.empty() || target[0] != '/' || !percent_decoded(target.substr(0, mark), false, request.path)) return false;
  if (mark < target.size() && !parse_query(target.substr(mark + 1), request)) return false;
  for (size_t at = end + 2; at < head.size();) {
    const size_t stop = head.find("\r\n", at);
    if (stop == std::string::npos || stop == at) break;
    const std::string line = head.substr(at, stop - at);
    const size_t colon = line.find(':');
    if (colon == std::string::npos || colon == 0 || line.find_first_of(std::string("\0\n\r", 3)) != std::string::npos)
      return false;
    const size_t from = std::min(line.find_first_not_of(" \t", colon + 1), line.size());
    std::string value = line.substr(from);
    value.erase(value.find_last_not_of(" \t") + 1);
    if (!request.headers.emplace(lower(line.substr(0, colon)), value).second) return false;
    at = stop + 2;
  }
  return true;
}

HttpServer::HttpServer(const std::string& host, int port) {
  // sendfile() knows no MSG_NOSIGNAL: whoever breaks off a download would end the program.
  std::signal(SIGPIPE, SIG_IGN);
  addrinfo hints{}, *found = nullptr;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE;
  const std::string service = std::to_string(port);
  if (const int error = getaddrinfo(host.c_str(), service.c_str(), &hints, &found))
    throw std::runtime_error("cannot listen on '" + host + "': " + gai_strerror(error));
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> all(found, freeaddrinfo);
  socket_ = socket(found->ai_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int yes = 1;
  if (socket_ >= 0) setsockopt(socket_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  if (socket_ < 0 || bind(socket_, found->ai_addr, found->ai_addrlen) != 0 || listen(socket_, 64) != 0) {
    const std::string why = std::strerror(errno);
    if (socket_ >= 0) close(socket_);
    throw std::runtime_error("cannot listen on " + host + ", port " + service + ": " + why +
                             (port > 0 ? "; choose another one with --port, or none for any that is free" : ""));
  }
  sockaddr_storage bound{};
  socklen_t size = sizeof bound;
  getsockname(socket_, reinterpret_cast<sockaddr*>(&bound), &size);
  port_ = ntohs(bound.ss_family == AF_INET6 ? reinterpret_cast<sockaddr_in6*>(&bound)->sin6_port
                                            : reinterpret_cast<sockaddr_in*>(&bound)->sin_port);
}

HttpServer::~HttpServer() { close(socket_); }

void HttpServer::run(const Handler& handler, const std::atomic<bool>& stop) {
  std::list<Connection> connections;  // the oldest one first
  const auto end = [](Connection& one) {
    one.thread.join();
    close(one.socket);
  };
  while (!stop) {
    pollfd one{socket_, POLLIN, 0};
    const int ready = poll(&one, 1, 100);
    for (auto it = connections.begin(); it != connections.end();)
      it = it->ended ? (end(*it), connections.erase(it)) : std::next(it);
    if (ready <= 0) continue;
    const int socket = accept4(socket_, nullptr, nullptr, SOCK_CLOEXEC);
    if (socket < 0) continue;
    if (connections.size() >= most_connections) {
      const auto oldest = std::find_if(connections.begin(), connections.end(), [](const auto& c) { return !c.told; });
      if (oldest != connections.end()) shutdown(oldest->socket, SHUT_RDWR), oldest->told = true;
    }
    if (connections.size() >= 2 * most_connections) {  // all of them at work
      close(socket);
      continue;
    }
    Connection& made = connections.emplace_back();
    made.socket = socket;
    try {
      made.thread = std::thread([&made, &handler] {
        serve(made.socket, handler);
        shutdown(made.socket, SHUT_RDWR);  // the socket itself is closed by who joins: its number must not be another's
        made.ended = true;
      });
    } catch (const std::system_error&) {  // no more threads to be had
      close(socket);
      connections.pop_back();
    }
  }
  for (Connection& one : connections) shutdown(one.socket, SHUT_RDWR);
  for (Connection& one : connections) end(one);
}

}  // namespace plumbline::cli
