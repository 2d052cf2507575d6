// What the host and a worker process say to each other, over one socket.
//
// The host asks for one run; the worker then calls the services of plumbline_host and ends with `done`. So all that a
// host does for a node (verification, store, memory, cancelling) is done in the host's own process, and a worker has
// nothing but the library. What a node only tells (log, progress, metric, fail) is not answered: order is kept by the
// socket, so the node need not wait.
#pragma once

#include <poll.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include <cerrno>
#include <string>

#include "runtime/base/wire.hpp"

namespace plumbline::runtime {

enum class Ask : uint8_t {
  run,  ///< library, its identity, kind, limit of memory in bytes (0: none), threads
  log,
  progress,
  cancelled,
  seed,
  metric,
  fail,
  parameter,
  item_count,
  get,
  commit,
  resolve,
  make_folder,
  digest,
  reserve_memory,
  done  ///< what run() returned, and the bytes that it took at most beyond what there was and its inputs
};

/// Each message is its length and that many bytes. `wait(events)` is called before each piece with POLLIN or POLLOUT
/// and says whether to go on. False if it did not, or the other side is gone.
template <typename Wait>
bool send_message(int socket, const std::string& body, const Wait& wait) {
  const uint64_t size = body.size();
  for (size_t at = 0; at < sizeof size + body.size();) {
    if (!wait(POLLOUT)) return false;
    iovec pieces[2];
    msghdr message{};
    message.msg_iov = pieces;
    if (at < sizeof size)
      pieces[message.msg_iovlen++] = {const_cast<char*>(reinterpret_cast<const char*>(&size)) + at, sizeof size - at};
    const size_t done = at < sizeof size ? 0 : at - sizeof size;
    pieces[message.msg_iovlen++] = {const_cast<char*>(body.data()) + done, body.size() - done};
    const ssize_t count = sendmsg(socket, &message, MSG_NOSIGNAL);
    if (count < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (count <= 0) return false;
    at += static_cast<size_t>(count);
  }
  return true;
}

template <typename Wait>
bool receive_exactly(int socket, char* data, size_t size, const Wait& wait) {
  for (size_t at = 0; at < size;) {
    if (!wait(POLLIN)) return false;
    const ssize_t count = recv(socket, data + at, size - at, 0);
    if (count < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (count <= 0) return false;
    at += static_cast<size_t>(count);
  }
  return true;
}

template <typename Wait>
bool receive_message(int socket, std::string& body, const Wait& wait) {
  uint64_t size = 0;
  if (!receive_exactly(socket, reinterpret_cast<char*>(&size), sizeof size, wait)) return false;
  if (size > (uint64_t{1} << 33)) return false;  // no artifact is that large
  body.resize(size);
  return receive_exactly(socket, body.data(), size, wait);
}

}  // namespace plumbline::runtime
