// SPDX-License-Identifier: Apache-2.0
// Files of arrays under a JSON header, every byte under a hash (docs/farm.md, "Byte layout").
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "irt/checkpoint/arrays.h"

namespace irt::checkpoint {

/// Bytes under one hash (xxh3, 64 bit).
inline constexpr std::size_t block = std::size_t{4} << 20;

/// What a file begins with; little-endian.
struct Preamble {
    char magic[8];
    std::uint64_t header_size;  ///< the JSON text, which follows
    std::uint64_t data_offset;  ///< a multiple of `page`; up to it from the preamble's end: zeros
    std::uint64_t data_size;    ///< then the hashes of its blocks begin
    std::uint64_t file_size;
    std::uint64_t header_hash;  ///< of the text and the zeros
    std::uint64_t table_hash;   ///< of the blocks' hashes
    std::uint64_t hash;         ///< of all before it
};
static_assert(sizeof(Preamble) == 64);
inline constexpr std::string_view magic = "irtckpt1";

/// Writes `path`: beside it, synced, renamed, so that it appears whole or not at all. Returns 0 or
/// what the system refused with; then `path` is as it was.
[[nodiscard]] int write(const std::string& path, std::string_view header,
                        const std::vector<ArrayEntry>& arrays, std::size_t data_size);

/// The same by a child of this process, which holds the memory as it is now while this one goes
/// on. The child ends with its parent, or when it is let go of.
class BackgroundWrite {
  public:
    BackgroundWrite(const std::string& path, std::string_view header,
                    const std::vector<ArrayEntry>& arrays, std::size_t data_size);
    ~BackgroundWrite() { cancel(); }
    BackgroundWrite(const BackgroundWrite&) = delete;
    BackgroundWrite& operator=(const BackgroundWrite&) = delete;

    /// Whether it has ended.
    [[nodiscard]] bool done();
    /// Ends it, and takes away what it had written.
    void cancel();
    /// Once done: as of `write`; -1: it was ended by force.
    [[nodiscard]] int result() const { return result_; }

  private:
    void reaped(int status);
    pid_t child_;
    std::string temporary_;
    int result_ = 0;
};

/// A file mapped to memory. Throws std::system_error where it cannot be read, std::runtime_error
/// where its preamble, its header or its size do not hold.
class MappedFile {
  public:
    explicit MappedFile(const std::string& path);
    ~MappedFile();
    MappedFile(const MappedFile&) = delete;
    MappedFile& operator=(const MappedFile&) = delete;

    [[nodiscard]] std::string_view header() const;
    [[nodiscard]] std::span<const std::byte> data() const;
    /// Compares all blocks with their hashes, on `threads` threads (0: all of the machine). Returns
    /// the numbers of those that differ.
    [[nodiscard]] std::vector<std::size_t> damaged(int threads) const;

  private:
    const std::byte* begin_ = nullptr;
    std::size_t size_ = 0;
    Preamble preamble_{};
};

/// xxh3, 128 bit, as 32 hexadecimal digits.
[[nodiscard]] std::string bytes_hash(std::string_view bytes);
/// The same of a file's bytes. Throws std::system_error.
[[nodiscard]] std::string file_hash(const std::string& path);

}  // namespace irt::checkpoint
