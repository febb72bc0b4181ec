#pragma once
// File descriptors that close themselves. None of them reaches another program unless it is handed over, see child.hpp.
//
//     Pipe pipe = make_pipe();
//     if (const int error = write_all(pipe.write.get(), bytes)) ...

#include <string>
#include <string_view>
#include <utility>

namespace tetfront {

class Descriptor {
 public:
    Descriptor() = default;
    explicit Descriptor(int number) : number_(number) {}
    ~Descriptor() { close(); }
    Descriptor(Descriptor&& other) noexcept : number_(other.release()) {}
    Descriptor& operator=(Descriptor&& other) noexcept {
        std::swap(number_, other.number_);
        return *this;
    }

    [[nodiscard]] int get() const { return number_; }  // -1: none
    int release() { return std::exchange(number_, -1); }
    void close();

 private:
    int number_ = -1;
};

struct Pipe {
    Descriptor read, write;
};
// Throw OutputError.
Pipe make_pipe();
Descriptor open_null();    // nothing to read, and takes everything
Descriptor make_buffer();  // a file without a name, in memory

/// 0, or the number of the error.
int write_all(int descriptor, std::string_view bytes);
/// Of a file: at most so many bytes before its end.
std::string read_end(int descriptor, std::size_t most);

}  // namespace tetfront
