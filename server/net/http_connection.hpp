#pragma once
// One HTTP connection: serves the web client's files and hands /ws over to a WebSocketConnection. Requests are answered
// one after another, so pipelined ones cannot start two writes. Included by server.cpp only, see there.

#include "engine/base/error.hpp"
#include "server/net/snapshot.hpp"
#include "server/net/websocket_connection.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace tetfront {

class HttpConnection : public Connection, public std::enable_shared_from_this<HttpConnection> {
 public:
    HttpConnection(Hub& hub, const Timeouts& timeouts, tcp::socket socket)
        : hub_(hub), timeouts_(timeouts), stream_(std::move(socket)) {}

    void read() {
        parser_.emplace();
        parser_->header_limit(max_header_bytes);
        stream_.expires_after(timeouts_.request);
        http::async_read_header(stream_, buffer_, *parser_, [self = shared_from_this()](Error error, std::size_t) {
            if (!error)
                self->on_request();
            else if (error == http::error::header_limit || error == http::error::buffer_overflow)
                self->refuse(http::status::request_header_fields_too_large, "the request's header is too large", false);
            else if (error.category() == make_error_code(http::error::bad_method).category() &&
                     error != http::error::end_of_stream && error != http::error::partial_message)
                self->refuse(http::status::bad_request, "the request is not HTTP", false);
            else
                self->finish();
        });
    }

    void shut_down() override { stream_.close(); }

 private:
    using Response = http::response<http::string_body>;

    void on_request() {
        const http::request<http::empty_body>& request = parser_->get();
        // A body would have to be skipped to find the next request; no request here has any.
        const bool keep_alive = request.keep_alive() && parser_->is_done();
        const auto hosts = request.count(http::field::host);
        if (hosts != 1 || !hub_.access.host_allowed(text(request[http::field::host])))
            return refuse(http::status::forbidden, "this server does not go by that Host", keep_alive);
        const auto origins = request.count(http::field::origin);
        if (origins > 1 || (origins == 1 && !hub_.access.origin_allowed(text(request[http::field::origin]))))
            return refuse(http::status::forbidden, "pages of another Origin may not use this server", keep_alive);
        if (request.method() != http::verb::get && request.method() != http::verb::head) {
            Response response = make(http::status::method_not_allowed, "use GET or HEAD\n", keep_alive);
            response.set(http::field::allow, "GET, HEAD");
            return send(std::move(response));
        }
        if (request.target() == "/ws") return on_websocket(keep_alive);
        if (text(request.target()).substr(0, text(request.target()).find('?')) == "/snapshot.png") return on_snapshot(keep_alive);
        const WebFile* file = find(hub_.files, text(request.target()));
        if (!file) return refuse(http::status::not_found, "there is no such page", keep_alive);
        send_file(*file, keep_alive);
    }

    void on_websocket(bool keep_alive) {
        const http::request<http::empty_body>& request = parser_->get();
        if (!websocket::is_upgrade(request)) {
            Response response =
                make(http::status::upgrade_required, "this address speaks WebSocket only\n", keep_alive);
            response.set(http::field::upgrade, "websocket");
            return send(std::move(response));
        }
        const http::token_list offered(request[http::field::sec_websocket_protocol]);
        if (std::none_of(offered.begin(), offered.end(), [](auto name) { return text(name) == subprotocol; }))
            return refuse(http::status::bad_request, "offer the WebSocket subprotocol tetfront.v1", keep_alive);
        if (buffer_.size() > 0)
            return refuse(http::status::bad_request, "bytes follow the request before it was answered", false);
        const auto viewer = std::make_shared<WebSocketConnection>(hub_, timeouts_, std::move(stream_));
        hub_.add(viewer);
        hub_.remove(shared_from_this());
        viewer->accept(request);
    }

    /// The answer comes when the picture is drawn; no other request is read meanwhile.
    void on_snapshot(bool keep_alive) {
        const http::request<http::empty_body>& request = parser_->get();
        const std::string_view target = text(request.target());
        if (!hub_.model()) return refuse_for_now("the model is still being built", keep_alive);
        SnapshotQuery query;
        try {
            const std::size_t mark = target.find('?');
            query = parse_snapshot_query(mark == std::string_view::npos ? "" : target.substr(mark + 1), hub_.model()->scene.view);
        } catch (const InputError& error) {
            return refuse(http::status::bad_request, error.what(), keep_alive);
        }
        const bool head = request.method() == http::verb::head;
        const auto refusal = hub_.snapshot(query, [self = shared_from_this(), keep_alive, head](auto result) {
            asio::post(self->stream_.get_executor(), [self, keep_alive, head, picture = std::move(result)]() mutable {
                self->send_snapshot(std::move(picture), keep_alive, head);
            });
        });
        if (refusal == Hub::Refusal::not_ready) return refuse_for_now("the first frame is still to come", keep_alive);
        if (refusal == Hub::Refusal::busy) {
            Response response = make(http::status::too_many_requests, "one picture at a time, ten a second\n", keep_alive);
            response.set(http::field::retry_after, "1");
            return send(std::move(response));
        }
    }

    void send_snapshot(SnapshotPainter::Result picture, bool keep_alive, bool head) {
        if (picture.png.empty()) return refuse(http::status::unprocessable_entity, picture.problem, keep_alive);
        const std::size_t size = picture.png.size();
        Response response = make(http::status::ok, head ? std::string() : std::move(picture.png), keep_alive);
        response.set(http::field::content_type, "image/png");
        if (head) response.content_length(size);
        send(std::move(response));
    }

    void refuse_for_now(const char* why, bool keep_alive) {
        Response response = make(http::status::service_unavailable, std::string(why) + '\n', keep_alive);
        response.set(http::field::retry_after, "1");
        send(std::move(response));
    }

    void send_file(const WebFile& file, bool keep_alive) {
        const http::request<http::empty_body>& request = parser_->get();
        const bool unchanged = request[http::field::if_none_match] == file.etag;
        const bool head = request.method() == http::verb::head;
        Response response = make(unchanged ? http::status::not_modified : http::status::ok,
                                 unchanged || head ? std::string() : file.bytes, keep_alive);
        response.set(http::field::content_type, file.content_type);
        response.set(http::field::etag, file.etag);
        response.set(http::field::cache_control, file.cache_control);
        if (head) response.content_length(file.bytes.size());
        send(std::move(response));
    }

    Response make(http::status status, std::string body, bool keep_alive) {
        Response response(status, 11);
        response.keep_alive(keep_alive);
        response.set(http::field::server, "tetfront");
        response.set(http::field::content_type, "text/plain; charset=utf-8");
        response.set(http::field::cache_control, "no-store");
        response.set("Content-Security-Policy", content_security_policy);
        response.set("X-Content-Type-Options", "nosniff");
        response.set("X-Frame-Options", "DENY");
        response.set("Referrer-Policy", "no-referrer");
        response.set("Cross-Origin-Opener-Policy", "same-origin");
        response.set("Cross-Origin-Resource-Policy", "same-origin");
        response.body() = std::move(body);
        response.prepare_payload();
        return response;
    }

    void refuse(http::status status, std::string_view why, bool keep_alive) {
        std::string body(why);
        if (parser_->get().method() == http::verb::head)
            body.clear();
        else
            body += '\n';
        send(make(status, std::move(body), keep_alive));
    }

    void send(Response response) {
        response_ = std::move(response);
        stream_.expires_after(timeouts_.request);
        http::async_write(stream_, response_, [self = shared_from_this()](Error error, std::size_t) {
            if (error)
                self->finish();
            else if (self->response_.need_eof())
                self->linger();
            else
                self->read();
        });
    }

    /// Lets the client read the answer: closing at once while it still sends would reset the connection.
    void linger() {
        Error ignored;  // gone already: then the read below says so
        stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
        stream_.expires_after(Timeouts::close);
        skip();
    }
    void skip() {
        stream_.async_read_some(asio::buffer(skipped_), [self = shared_from_this()](Error error, std::size_t) {
            if (error)
                self->finish();
            else
                self->skip();
        });
    }

    void finish() {
        stream_.close();
        hub_.remove(shared_from_this());
    }

    static std::string_view text(beast::string_view s) { return {s.data(), s.size()}; }

    static constexpr std::size_t max_header_bytes = 8 * 1024;
    // The client is scripts, styles and a worker of our own files; nothing inline, nothing from elsewhere.
    static constexpr const char* content_security_policy =
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; font-src 'self'; "
        "connect-src 'self'; worker-src 'self'; manifest-src 'self'; base-uri 'none'; form-action 'none'; "
        "frame-ancestors 'none'";

    Hub& hub_;
    Timeouts timeouts_;
    beast::tcp_stream stream_;
    beast::flat_buffer buffer_{2 * max_header_bytes};
    std::optional<http::request_parser<http::empty_body>> parser_;
    Response response_;
    std::array<char, 4096> skipped_{};
};

}  // namespace tetfront
