// A TCP port of this machine that nobody listens on.
#pragma once

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace ld {

inline int free_port() {
  const int socket_number = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof address;
  // Port 0 asks the system for a free one.
  if (bind(socket_number, reinterpret_cast<sockaddr*>(&address), length) != 0 ||
      getsockname(socket_number, reinterpret_cast<sockaddr*>(&address), &length) != 0)
    ADD_FAILURE() << "no free port";
  close(socket_number);
  return ntohs(address.sin_port);
}

}  // namespace ld
