#pragma once
// One HTTP connection: serves the web client's files and hands /ws over to a WebSocketConnection. Requests are answered
// one after another, so pipelined ones cannot start two writes. Included by server.cpp only, see there.

#include "engine/base/error.hpp"
#include "server/net/child_stream.hpp"
#include "server/net/exports.hpp"
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
                self->take_request();
            else if (error == http::error::header_limit || error == http::error::buffer_overflow)
                self->refuse(http::status::request_header_fields_too_large, "the request's header is too large", false);
            else if (error.category() == make_error_code(http::error::bad_method).category() &&
                     error != http::error::end_of_stream && error != http::error::partial_message)
                self->refuse(http::status::bad_request, "the request is not HTTP", false);
            else
                self->finish();
        });
    }

    /// A short answer that is being sent is sent whole.
    void shut_down() override {
        ending_ = true;
        if (child_) child_->stop();
        if (!answering_) stream_.close();
    }

 private:
    using Response = http::response<http::string_body>;

    void take_request() {
        try {
            on_request();
        } catch (const std::exception& error) {  // without an answer and a next read the connection would stay forever
            spdlog::error("while answering {}: {}", text(parser_->get().target()).substr(0, 100), error.what());
            refuse(http::status::internal_server_error, "the server could not answer", false);
        }
    }

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
        ++hub_.metrics.requests;
        if (hub_.connections_of(address) > hub_.limits.connections_per_address && !websocket::is_upgrade(request)) {
            ++hub_.metrics.refused_connections;
            return refuse(http::status::too_many_requests, "there are too many connections from your address", false);
        }
        const std::string_view path = text(request.target()).substr(0, text(request.target()).find('?'));
        if (request.target() == "/ws") return on_websocket(keep_alive);
        if (path == "/healthz") return on_health(keep_alive);
        if (path == "/readyz") return on_ready(keep_alive);
        if (path == "/session") return on_session(keep_alive);
        const bool guarded = path == "/snapshot.png" || path == "/metrics" || path.starts_with("/recordings/") || path.starts_with("/thumbnails/");
        if (guarded && !authorized()) return refuse_token(keep_alive);
        if (path == "/snapshot.png") return on_snapshot(keep_alive);
        if (path == "/metrics") return on_metrics(keep_alive);
        if (is_export(path)) return send_export(path, keep_alive);
        if (path.starts_with("/recordings/")) return send_recording(path.substr(12), keep_alive);
        if (path.starts_with("/thumbnails/")) return send_thumbnail(path.substr(12), keep_alive);
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
        const std::string_view chosen = choose_subprotocol(request[http::field::sec_websocket_protocol]);
        if (chosen.empty()) return refuse(http::status::bad_request, "offer the WebSocket subprotocol tetfront.v1", keep_alive);
        if (buffer_.size() > 0)
            return refuse(http::status::bad_request, "bytes follow the request before it was answered", false);
        const auto viewer = std::make_shared<WebSocketConnection>(hub_, timeouts_, std::move(stream_), std::string(chosen), authorized());
        viewer->address = address;
        hub_.add(viewer);
        hub_.remove(shared_from_this());
        viewer->accept(request);
    }

    /// Ours, or else another version of ours; empty: neither is offered.
    static std::string_view choose_subprotocol(beast::string_view offers) {
        std::string_view chosen;
        for (const auto name : http::token_list(offers)) {
            if (text(name) == subprotocol) return subprotocol;
            if (text(name).starts_with("tetfront.v")) chosen = text(name);
        }
        return chosen;
    }

    [[nodiscard]] bool authorized() const {
        const http::request<http::empty_body>& request = parser_->get();
        return hub_.access.authorized(text(request[http::field::authorization]), text(request[http::field::cookie]));
    }
    void refuse_token(bool keep_alive) {
        Response response = make(http::status::unauthorized, "a token is needed: Authorization: Bearer TOKEN\n", keep_alive);
        response.set(http::field::www_authenticate, "Bearer");
        send(std::move(response));
    }

    /// Exchanges the token for a cookie, which pages and their WebSockets send by themselves.
    void on_session(bool keep_alive) {
        if (!authorized()) return refuse_token(keep_alive);
        Response response = make(http::status::no_content, "", keep_alive);
        if (hub_.access.needs_token()) response.set(http::field::set_cookie, hub_.access.cookie());
        send(std::move(response));
    }
    void on_health(bool keep_alive) {
        const std::string problem = hub_.stalled();
        if (!problem.empty()) return refuse(http::status::service_unavailable, problem, keep_alive);
        answer("ok\n", keep_alive);
    }
    void on_ready(bool keep_alive) {
        if (!hub_.ready() || hub_.shutting_down()) return refuse_for_now("there is no frame yet", keep_alive);
        answer("ok\n", keep_alive);
    }
    void on_metrics(bool keep_alive) { answer(hub_.metrics_page(), keep_alive, "text/plain; version=0.0.4; charset=utf-8"); }

    void answer(std::string body, bool keep_alive, const char* type = "text/plain; charset=utf-8") {
        const std::size_t size = body.size();
        const bool head = parser_->get().method() == http::verb::head;
        Response response = make(http::status::ok, head ? std::string() : std::move(body), keep_alive);
        response.set(http::field::content_type, type);
        if (head) response.content_length(size);
        send(std::move(response));
    }

    /// name: from the client, looked up in a listing. The file is read piece by piece while it is sent.
    void send_recording(std::string_view name, bool keep_alive) {
        const auto entry = find(hub_.session.settings().library.recordings(), name);
        beast::error_code error;
        http::file_body::value_type file;
        if (entry) file.open(entry->path.c_str(), beast::file_mode::scan, error);
        if (!entry || error) return refuse(http::status::not_found, "there is no such recording", keep_alive);
        http::response<http::file_body> response(http::status::ok, 11);
        const std::uint64_t size = file.size();
        set_headers(response, keep_alive);
        response.set(http::field::content_type, "application/octet-stream");
        response.set(http::field::content_disposition, "attachment; filename=\"" + entry->name + "\"");
        if (parser_->get().method() == http::verb::head) {
            Response head = make(http::status::ok, "", keep_alive);
            head.set(http::field::content_type, "application/octet-stream");
            head.content_length(size);
            return send(std::move(head));
        }
        response.body() = std::move(file);
        response.prepare_payload();
        const auto kept = std::make_shared<http::response<http::file_body>>(std::move(response));
        const auto serializer = std::make_shared<http::response_serializer<http::file_body>>(*kept);
        send_pieces(kept, serializer);
    }

    /// Each piece has its own time: a long download may take as long as it moves.
    void send_pieces(std::shared_ptr<http::response<http::file_body>> kept, std::shared_ptr<http::response_serializer<http::file_body>> serializer) {
        stream_.expires_after(timeouts_.idle);
        http::async_write_some(stream_, *serializer, [self = shared_from_this(), kept, serializer](Error failed, std::size_t) {
            if (failed)
                self->finish();
            else if (!serializer->is_done())
                self->send_pieces(kept, serializer);
            else if (kept->need_eof())
                self->linger();
            else
                self->read();
        });
    }

    /// Pictures or a video of a recording, drawn by another process while they are sent.
    void send_export(std::string_view path, bool keep_alive) {
        const http::request<http::empty_body>& request = parser_->get();
        const std::string_view target = text(request.target());
        std::optional<Export> wanted;
        try {
            wanted = find_export(hub_.session.settings().library, path, target.substr(std::min(target.size(), path.size() + 1)));
        } catch (const InputError& error) {
            return refuse(http::status::bad_request, error.what(), keep_alive);
        }
        if (!wanted) return refuse(http::status::not_found, "there is no such recording", keep_alive);
        if (request.version() < 11) return refuse(http::status::http_version_not_supported, "use HTTP/1.1: it comes in chunks", keep_alive);
        ChildStream::Header header(http::status::ok, 11);
        set_headers(header, keep_alive);
        header.set(http::field::content_type, wanted->content_type);
        header.set(http::field::content_disposition, "attachment; filename=\"" + wanted->file + "\"");
        if (request.method() == http::verb::head) return send_head(std::move(header), keep_alive);
        if (hub_.exports >= Hub::most_exports) {
            Response response = make(http::status::too_many_requests, "other recordings are being drawn; try again later\n", keep_alive);
            response.set(http::field::retry_after, "10");
            return send(std::move(response));
        }
        try {
            child_ = std::make_shared<ChildStream>(stream_, wanted->words);
        } catch (const OutputError& error) {
            return refuse(http::status::service_unavailable, error.what(), keep_alive);
        }
        ++hub_.exports;
        child_->start(std::move(header), timeouts_.request, timeouts_.download, [self = shared_from_this(), keep_alive](const ChildStream::End& end) {
            --self->hub_.exports;
            self->child_.reset();
            if (end.outcome == ChildStream::Outcome::refused)
                self->refuse(http::status::unprocessable_entity, self->hub_.session.settings().library.without_folders(end.problem), keep_alive);
            else if (end.outcome == ChildStream::Outcome::sent && keep_alive)
                self->read();
            else
                self->finish();
        });
    }

    /// Of an answer that would come in chunks: how long it would be is not known.
    void send_head(ChildStream::Header header, bool keep_alive) {
        header.chunked(true);
        const auto kept = std::make_shared<ChildStream::Header>(std::move(header));
        const auto serializer = std::make_shared<http::response_serializer<http::empty_body>>(*kept);
        stream_.expires_after(timeouts_.request);
        http::async_write_header(stream_, *serializer, [self = shared_from_this(), kept, serializer, keep_alive](Error error, std::size_t) {
            if (error)
                self->finish();
            else if (keep_alive)
                self->read();
            else
                self->linger();
        });
    }

    /// The answer comes when it is drawn; no other request is read meanwhile.
    void send_thumbnail(std::string_view name, bool keep_alive) {
        const std::string scene(name.substr(0, name.size() - std::min<std::size_t>(name.size(), 4)));
        if (!name.ends_with(".png") || !hub_.session.settings().library.scene_file(scene))
            return refuse(http::status::not_found, "there is no such scene", keep_alive);
        hub_.thumbnail(scene, [self = shared_from_this(), keep_alive](const std::string& png) {
            if (png.empty()) return self->send(self->make(http::status::no_content, "", keep_alive));
            self->answer(png, keep_alive, "image/png");
        });
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
        set_headers(response, keep_alive);
        response.body() = std::move(body);
        response.prepare_payload();
        if (static_cast<unsigned>(status) >= 400) ++hub_.metrics.errors[std::to_string(static_cast<unsigned>(status))];
        return response;
    }

    template <class Message>
    static void set_headers(Message& response, bool keep_alive) {
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
        answering_ = true;
        stream_.expires_after(timeouts_.request);
        http::async_write(stream_, response_, [self = shared_from_this()](Error error, std::size_t) {
            self->answering_ = false;
            if (error)
                self->finish();
            else if (self->response_.need_eof() || self->ending_)
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
    std::shared_ptr<ChildStream> child_;
    std::array<char, 4096> skipped_{};
    bool answering_ = false, ending_ = false;
};

}  // namespace tetfront
