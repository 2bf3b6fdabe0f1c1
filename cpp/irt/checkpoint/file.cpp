// SPDX-License-Identifier: Apache-2.0
#include "irt/checkpoint/file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <system_error>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "irt/cells/cells.h"

namespace irt::checkpoint {

namespace {

std::uint64_t hash_of(const void* bytes, std::size_t size) { return XXH3_64bits(bytes, size); }

std::size_t rounded_up(std::size_t size, std::size_t to) { return (size + to - 1) / to * to; }

std::size_t blocks_in(std::size_t size) { return (size + block - 1) / block; }

/// Writes at the end of a file, hashing block by block. A failure stops it for good.
class BlockWriter {
  public:
    explicit BlockWriter(int file) : file_(file) { XXH3_64bits_reset(&state_); }

    void put(std::span<const std::byte> bytes) {
        while (!bytes.empty() && error_ == 0) {
            const std::span<const std::byte> part =
                bytes.first(std::min(bytes.size(), block - filled_));
            XXH3_64bits_update(&state_, part.data(), part.size());
            pieces_.push_back({const_cast<std::byte*>(part.data()), part.size()});
            filled_ += part.size();
            written_ += part.size();
            bytes = bytes.subspan(part.size());
            if (filled_ == block) end_block();
            if (pieces_.size() == IOV_MAX) flush();
        }
    }
    void zeros_up_to(std::size_t offset) {
        static const std::array<std::byte, page> zeros{};
        while (written_ < offset && error_ == 0)
            put(std::span(zeros).first(std::min(offset - written_, page)));
    }
    void end() {
        if (filled_ > 0) end_block();
        flush();
    }
    [[nodiscard]] const std::vector<std::uint64_t>& hashes() const { return hashes_; }
    [[nodiscard]] int error() const { return error_; }

  private:
    void end_block() {
        hashes_.push_back(XXH3_64bits_digest(&state_));
        XXH3_64bits_reset(&state_);
        filled_ = 0;
        flush();
    }
    void flush() {
        std::size_t first = 0;
        while (first < pieces_.size() && error_ == 0) {
            ssize_t count =
                ::writev(file_, pieces_.data() + first, static_cast<int>(pieces_.size() - first));
            if (count < 0) {
                if (errno != EINTR) error_ = errno;
                continue;
            }
            for (; first < pieces_.size(); ++first) {
                iovec& piece = pieces_[first];
                const std::size_t taken = std::min(piece.iov_len, static_cast<std::size_t>(count));
                piece.iov_base = static_cast<std::byte*>(piece.iov_base) + taken;
                piece.iov_len -= taken;
                count -= static_cast<ssize_t>(taken);
                if (piece.iov_len > 0) break;
            }
        }
        pieces_.clear();
    }

    int file_, error_ = 0;
    XXH3_state_t state_;
    std::size_t filled_ = 0, written_ = 0;
    std::vector<iovec> pieces_;
    std::vector<std::uint64_t> hashes_;
};

int fill(int file, std::string_view header, const std::vector<ArrayEntry>& arrays,
         std::size_t data_size) {
    Preamble preamble{};
    std::copy(magic.begin(), magic.end(), preamble.magic);
    preamble.header_size = header.size();
    preamble.data_offset = rounded_up(sizeof(Preamble) + header.size(), page);
    preamble.data_size = data_size;
    const std::size_t count = blocks_in(data_size);
    preamble.file_size = preamble.data_offset + data_size + count * sizeof(std::uint64_t);
    std::vector<std::byte> head(preamble.data_offset - sizeof(Preamble));
    std::memcpy(head.data(), header.data(), header.size());
    preamble.header_hash = hash_of(head.data(), head.size());

    // Where there is no room for the whole file, that is found out before it is filled.
    if (::fallocate(file, 0, 0, static_cast<off_t>(preamble.file_size)) != 0 &&
        (errno == ENOSPC || errno == EDQUOT || errno == EFBIG))
        return errno;
    if (::lseek(file, static_cast<off_t>(preamble.data_offset), SEEK_SET) < 0) return errno;
    BlockWriter data(file);
    for (const ArrayEntry& array : arrays) {
        data.zeros_up_to(array.offset);
        for (const std::span<const std::byte> piece : array.pieces) data.put(piece);
    }
    data.end();
    if (data.error() != 0) return data.error();
    preamble.table_hash = hash_of(data.hashes().data(), count * sizeof(std::uint64_t));
    preamble.hash = hash_of(&preamble, offsetof(Preamble, hash));
    BlockWriter table(file);
    table.put(std::as_bytes(std::span(data.hashes())));
    table.end();
    if (table.error() != 0) return table.error();
    if (::lseek(file, 0, SEEK_SET) < 0) return errno;
    BlockWriter front(file);
    front.put(std::as_bytes(std::span(&preamble, 1)));
    front.put(head);
    front.end();
    if (front.error() != 0) return front.error();
    return ::fsync(file) == 0 ? 0 : errno;
}

std::string folder_of(const std::string& path) {
    const std::size_t slash = path.rfind('/');
    return slash == std::string::npos ? "." : path.substr(0, slash + 1);
}

int sync_folder(const std::string& path) {
    const int folder = ::open(folder_of(path).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder < 0) return errno;
    const int error = ::fsync(folder) == 0 ? 0 : errno;
    ::close(folder);
    return error;
}

std::string hexadecimal(const XXH128_hash_t& hash) {
    char text[33];
    std::snprintf(text, sizeof(text), "%016llx%016llx",
                  static_cast<unsigned long long>(hash.high64),
                  static_cast<unsigned long long>(hash.low64));
    return text;
}

std::string temporary_name(const std::string& path) { return path + ".tmp"; }

}  // namespace

int write(const std::string& path, std::string_view header, const std::vector<ArrayEntry>& arrays,
          std::size_t data_size) {
    const std::string temporary = temporary_name(path);
    const int file = ::open(temporary.c_str(), O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC, 0666);
    if (file < 0) return errno;
    int error = fill(file, header, arrays, data_size);
    if (::close(file) != 0 && error == 0) error = errno;
    if (error == 0 && ::rename(temporary.c_str(), path.c_str()) != 0) error = errno;
    if (error != 0) {
        ::unlink(temporary.c_str());
        return error;
    }
    return sync_folder(path);
}

BackgroundWrite::BackgroundWrite(const std::string& path, std::string_view header,
                                 const std::vector<ArrayEntry>& arrays, std::size_t data_size)
    : child_(0), temporary_(temporary_name(path)) {
    const pid_t parent = ::getpid();
    child_ = ::fork();
    if (child_ < 0) throw std::system_error(errno, std::generic_category(), "fork");
    if (child_ > 0) return;
    // Signals are the parent's to act upon; nothing is said; the end of the parent ends it all.
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(1);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGXFSZ}) ::signal(signal, SIG_IGN);
    const int nothing = ::open("/dev/null", O_RDWR);
    for (const int stream : {0, 1, 2}) ::dup2(nothing, stream);
    ::_exit(write(path, header, arrays, data_size) & 0xff);
}

bool BackgroundWrite::done() {
    if (child_ <= 0) return true;
    int status = 0;
    const pid_t ended = ::waitpid(child_, &status, WNOHANG);
    if (ended == 0 || (ended < 0 && errno == EINTR)) return false;
    reaped(status);
    return true;
}

void BackgroundWrite::cancel() {
    if (done()) return;
    ::kill(child_, SIGKILL);
    int status = 0;
    while (::waitpid(child_, &status, 0) < 0 && errno == EINTR) continue;
    reaped(status);
}

void BackgroundWrite::reaped(int status) {
    child_ = 0;
    result_ = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    if (result_ != 0) ::unlink(temporary_.c_str());
}

MappedFile::MappedFile(const std::string& path) {
    const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (file < 0) throw std::system_error(errno, std::generic_category(), path);
    struct stat found {};
    const bool told = ::fstat(file, &found) == 0;
    if (told && found.st_size >= static_cast<off_t>(sizeof(Preamble))) {
        size_ = static_cast<std::size_t>(found.st_size);
        void* mapped = ::mmap(nullptr, size_, PROT_READ, MAP_SHARED, file, 0);
        if (mapped != MAP_FAILED) begin_ = static_cast<const std::byte*>(mapped);
    }
    const int error = errno;
    ::close(file);
    if (told && size_ == 0) throw std::runtime_error("is too short");
    if (!begin_) throw std::system_error(error, std::generic_category(), path);
    try {
        std::memcpy(&preamble_, begin_, sizeof(Preamble));
        if (std::string_view(preamble_.magic, sizeof(preamble_.magic)) != magic)
            throw std::runtime_error("is no file of this kind, or its first bytes are damaged");
        if (preamble_.hash != hash_of(&preamble_, offsetof(Preamble, hash)))
            throw std::runtime_error("its preamble is damaged");
        if (preamble_.file_size != size_)
            throw std::runtime_error("has " + std::to_string(size_) + " bytes in place of " +
                                     std::to_string(preamble_.file_size));
        if (preamble_.header_hash !=
            hash_of(begin_ + sizeof(Preamble), preamble_.data_offset - sizeof(Preamble)))
            throw std::runtime_error("its header is damaged");
        if (preamble_.table_hash != hash_of(begin_ + preamble_.data_offset + preamble_.data_size,
                                            blocks_in(preamble_.data_size) * sizeof(std::uint64_t)))
            throw std::runtime_error("its table of hashes is damaged");
    } catch (...) {
        ::munmap(const_cast<std::byte*>(begin_), size_);
        throw;
    }
}

MappedFile::~MappedFile() { ::munmap(const_cast<std::byte*>(begin_), size_); }

std::string_view MappedFile::header() const {
    return {reinterpret_cast<const char*>(begin_) + sizeof(Preamble), preamble_.header_size};
}

std::span<const std::byte> MappedFile::data() const {
    return {begin_ + preamble_.data_offset, preamble_.data_size};
}

std::vector<std::size_t> MappedFile::damaged(int threads) const {
    const std::size_t count = blocks_in(preamble_.data_size);
    std::vector<std::uint64_t> hashes(count);
    std::memcpy(hashes.data(), data().data() + preamble_.data_size, count * sizeof(std::uint64_t));
    std::vector<std::uint8_t> differs(count);
    cells::for_each_task(threads, static_cast<int>(count), [&](int task) {
        const auto i = static_cast<std::size_t>(task);
        const std::span<const std::byte> bytes =
            data().subspan(i * block, std::min(block, preamble_.data_size - i * block));
        differs[i] = hash_of(bytes.data(), bytes.size()) != hashes[i];
    });
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < count; ++i)
        if (differs[i]) found.push_back(i);
    return found;
}

std::string bytes_hash(std::string_view bytes) {
    return hexadecimal(XXH3_128bits(bytes.data(), bytes.size()));
}

std::string file_hash(const std::string& path) {
    const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (file < 0) throw std::system_error(errno, std::generic_category(), path);
    std::vector<std::byte> buffer(std::size_t{1} << 20);
    XXH3_state_t state;
    XXH3_128bits_reset(&state);
    ssize_t count;
    while ((count = ::read(file, buffer.data(), buffer.size())) != 0) {
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) break;
        XXH3_128bits_update(&state, buffer.data(), static_cast<std::size_t>(count));
    }
    const int error = errno;
    ::close(file);
    if (count < 0) throw std::system_error(error, std::generic_category(), path);
    return hexadecimal(XXH3_128bits_digest(&state));
}

}  // namespace irt::checkpoint
