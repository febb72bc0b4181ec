#pragma once
// Sends what a child process writes to a client while it writes it, in HTTP chunks. The child never gets ahead by more
// than a pipe, and is stopped when the client leaves. Included by server.cpp only, see there.
//
//     const auto child = std::make_shared<ChildStream>(stream, words);
//     child->start(header, piece, whole, [](ChildStream::End end) { ... });

#include "server/net/child_output.hpp"

#include <array>
#include <cerrno>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <boost/asio/error.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>

#include <sys/socket.h>

namespace tetfront {

class ChildStream : public std::enable_shared_from_this<ChildStream> {
 public:
    enum class Outcome {
        sent,     // all of it; the connection can go on
        refused,  // the child failed before it wrote anything: `problem` says why, and nothing was sent
        broken,   // the child failed later, or the client went: the connection cannot go on
    };
    struct End {
        Outcome outcome;
        std::string problem;
    };
    using Header = boost::beast::http::response<boost::beast::http::empty_body>;

    /// Starts the child. Throws OutputError.
    ChildStream(boost::beast::tcp_stream& stream, std::vector<std::string> words)
        : stream_(stream), child_(stream.get_executor(), std::move(words)) {}

    /// `done` is called once, later. piece: how long one may take to be taken; whole: all of it, or the process is stopped.
    void start(Header header, std::chrono::milliseconds piece, std::chrono::milliseconds whole, std::function<void(End)> done) {
        header_ = std::move(header), timeout_ = piece, done_ = std::move(done);
        header_.chunked(true);
        deadline_.expires_after(whole);
        deadline_.async_wait([weak = weak_from_this()](Error error) {
            if (const auto self = weak.lock(); self && !error) self->stop();
        });
        watch();
        read();
    }
    void stop() { child_.stop(); }

 private:
    using Error = boost::system::error_code;

    /// Before the first piece nothing is sent, so nothing else would tell that the client has gone.
    void watch() {
        stream_.socket().async_wait(boost::asio::ip::tcp::socket::wait_read, [weak = weak_from_this()](Error error) {
            const auto self = weak.lock();
            if (!self || error == boost::asio::error::operation_aborted) return;
            char next = 0;
            const ssize_t size = ::recv(self->stream_.socket().native_handle(), &next, 1, MSG_PEEK | MSG_DONTWAIT);
            if (size < 0 && errno == EAGAIN) return self->watch();
            if (size > 0) return;  // its next request, behind which its end cannot be seen: the next piece will tell
            self->gone_ = true;
            self->stop();  // and reading fails
        });
    }
    void read() {
        child_.read(boost::asio::buffer(piece_), [self = shared_from_this()](Error error, std::size_t size) {
            if (error) return self->on_end(error);
            if (self->began_) return self->send(size);
            self->began_ = true;
            self->stream_.expires_after(self->timeout_);
            boost::beast::http::async_write_header(self->stream_, self->serializer_, [self, size](Error failed, std::size_t) {
                failed ? self->lose() : self->send(size);
            });
        });
    }
    void send(std::size_t size) {
        stream_.expires_after(timeout_);
        boost::asio::async_write(stream_, boost::beast::http::make_chunk(boost::asio::const_buffer(piece_.data(), size)),
                                 [self = shared_from_this()](Error error, std::size_t) {
                                     error ? self->lose() : self->read();
                                 });
    }
    /// What was drawn cannot be sent.
    void lose() {
        gone_ = true;
        on_end(boost::asio::error::operation_aborted);
    }
    void on_end(Error error) {
        if (error != boost::asio::error::eof) child_.stop();
        child_.wait([self = shared_from_this()](ChildOutput::End end) {
            if (!end.problem.empty() || self->gone_)
                return self->end({self->began_ || self->gone_ ? Outcome::broken : Outcome::refused, std::move(end.problem)});
            self->stream_.expires_after(self->timeout_);
            boost::asio::async_write(self->stream_, boost::beast::http::make_chunk_last(), [self](Error failed, std::size_t) {
                self->end({failed ? Outcome::broken : Outcome::sent, ""});
            });
        });
    }
    void end(End how) {
        deadline_.cancel();
        Error ignored;  // closed already
        stream_.socket().cancel(ignored);
        std::exchange(done_, nullptr)(std::move(how));
    }

    boost::beast::tcp_stream& stream_;
    ChildOutput child_;
    boost::asio::steady_timer deadline_{stream_.get_executor()};
    Header header_;
    boost::beast::http::response_serializer<boost::beast::http::empty_body> serializer_{header_};
    std::chrono::milliseconds timeout_{};
    std::function<void(End)> done_;
    bool began_ = false, gone_ = false;
    std::array<char, 64 * 1024> piece_{};
};

}  // namespace tetfront
