/* SPDX-License-Identifier: MIT */
/* shim.c - a library to put before a program (LD_PRELOAD) that lets one of its calls fail, once.
 *
 * Counted from the begin of main() are allocations (malloc and its like), system calls that glibc makes on files (read,
 * write, open, rename, sync, make, look, close), and starts of processes and threads. A call has a site:
 * its innermost return addresses, so that each site can be visited instead of each call.
 *
 * System calls are met by a seccomp filter: those of the kinds above that are made from glibc's code come to a handler
 * of SIGSYS. So what stdio writes when its buffer is full is met like any write(). Other programs' code lies elsewhere
 * in memory, so that what is started runs undisturbed.
 *
 *   FAULTS_STATE=FILE   what is counted: a struct state, kept in memory that the processes of one run share. Without it
 *                       nothing is done.
 *   FAULTS_AT=N         the N-th call (from 1) of the kind
 *   FAULTS_KIND=KIND    fails
 *   FAULTS_HOW=HOW      as ENOSPC, EIO, EINTR, ...: the error's number in decimal; 0: a short count; -9: the process is
 *                       killed where it would make the call
 *   FAULTS_LEAST=BYTES  allocations of less are not met
 *   FAULTS_DEPTH=N      return addresses that tell sites apart, at most 16; 0: sites are not recorded
 * / */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <execinfo.h>
#include <fcntl.h>
#include <link.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <pthread.h>
#include <signal.h>
#include <spawn.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <ucontext.h>
#include <unistd.h>

enum kind { MEMORY, READ, WRITE, OPEN, RENAME, SYNC, MAKE, LOOK, CLOSE, START, KINDS };
static const char *const kind_names[KINDS] = {"memory", "read", "write", "open",  "rename",
                                              "sync",   "make", "look",  "close", "start"};

enum { FRAMES = 16, MODULES = 256, SITES = 1 << 15, SKIPPED = 2 };

struct site {
    _Atomic uint64_t hash;
    uint64_t kind, first, count; /* first: the number of the call, from 1 */
    uint32_t module[FRAMES], offset[FRAMES];
};
struct state { /* faults.py reads it */
    _Atomic uint64_t calls[KINDS];
    _Atomic uint64_t failed; /* 1: the call came, and failed */
    uint32_t failed_module[FRAMES], failed_offset[FRAMES];
    _Atomic uint64_t module_count, site_count;
    char module[MODULES][64];
    struct site sites[SITES];
};

static struct state *state;
static int chosen_kind = -1, how, depth;
static uint64_t chosen;
static size_t least;
static bool armed; /* main() has begun */
static __thread int busy __attribute__((tls_model("initial-exec")));

static long raw(long number, long a, long b, long c, long d, long e, long f)
{
    register long r10 __asm__("r10") = d, r8 __asm__("r8") = e, r9 __asm__("r9") = f;
    long result;
    __asm__ volatile("syscall"
                     : "=a"(result)
                     : "a"(number), "D"(a), "S"(b), "d"(c), "r"(r10), "r"(r8), "r"(r9)
                     : "rcx", "r11", "memory");
    return result;
}

/* ---- sites ---- */

static uint32_t number_of_module(const char *name)
{
    const char *slash = strrchr(name, '/');
    name = slash ? slash + 1 : *name ? name : "isoshade";
    const uint64_t count = atomic_load(&state->module_count);
    for (uint32_t i = 0; i < count && i < MODULES; ++i)
        if (strncmp(state->module[i], name, 63) == 0)
            return i;
    const uint64_t i = atomic_fetch_add(&state->module_count, 1);
    if (i >= MODULES)
        return MODULES - 1;
    strncpy(state->module[i], name, 63);
    return (uint32_t)i;
}

/* The innermost frames without the shim's own. */
static int take_frames(uint32_t module[FRAMES], uint32_t offset[FRAMES])
{
    void *at[FRAMES + 8];
    struct dl_find_object found, own;
    const int n = backtrace(at, FRAMES + 8);
    int count = 0;
    if (_dl_find_object((void *)take_frames, &own) != 0)
        return 0;
    for (int i = 0; i < n && count < FRAMES; ++i) {
        if (_dl_find_object(at[i], &found) != 0 || found.dlfo_map_start == own.dlfo_map_start)
            continue;
        module[count] = number_of_module(found.dlfo_link_map->l_name);
        offset[count++] = (uint32_t)((char *)at[i] - (char *)found.dlfo_link_map->l_addr);
    }
    return count;
}

static void record(enum kind kind, uint64_t number)
{
    uint32_t module[FRAMES] = {0}, offset[FRAMES] = {0};
    const int count = take_frames(module, offset);
    uint64_t hash = 0xcbf29ce484222325ULL ^ (uint64_t)kind;
    for (int i = 0; i < count && i < depth; ++i)
        hash = ((hash ^ module[i]) * 0x100000001b3ULL ^ offset[i]) * 0x100000001b3ULL;
    hash |= 1;
    for (uint64_t i = hash % SITES, tries = 0; tries < 64; i = (i + 1) % SITES, ++tries) {
        struct site *s = &state->sites[i];
        uint64_t there = 0;
        if (atomic_compare_exchange_strong(&s->hash, &there, hash)) {
            s->kind = kind;
            s->first = number;
            memcpy(s->module, module, sizeof module);
            memcpy(s->offset, offset, sizeof offset);
            atomic_fetch_add(&state->site_count, 1);
            there = hash;
        }
        if (there == hash) {
            ++s->count;
            return;
        }
    }
}

/* Is it this call that has to fail? */
static bool meets(enum kind kind)
{
    if (!armed || busy)
        return false;
    busy = 1;
    const uint64_t number = atomic_fetch_add(&state->calls[kind], 1) + 1;
    const bool fails = kind == (enum kind)chosen_kind && number == chosen;
    if (depth > 0)
        record(kind, number);
    if (fails) {
        take_frames(state->failed_module, state->failed_offset);
        state->failed = 1;
        if (how < 0)
            raw(SYS_kill, raw(SYS_getpid, 0, 0, 0, 0, 0, 0), -how, 0, 0, 0, 0);
    }
    busy = 0;
    return fails;
}

/* ---- what is behind ---- */

static void *next(const char *name)
{
    const int before = busy;
    busy = 1;
    void *f = dlsym(RTLD_NEXT, name);
    busy = before;
    return f;
}

/* All at once, before main(): dlsym() takes the loader's lock, which may never be released in a forked process. */
static struct {
    pid_t (*fork)(void);
    int (*execv)(const char *, char *const[]);
    int (*pipe2)(int *, int);
    int (*socketpair)(int, int, int, int *);
    int (*create)(pthread_t *, const pthread_attr_t *, void *(*)(void *), void *);
    int (*mask)(int, const sigset_t *, sigset_t *);
} libc;

static void find_real(void)
{
    if (libc.mask)
        return;
    *(void **)&libc.fork = next("fork");
    *(void **)&libc.execv = next("execv");
    *(void **)&libc.pipe2 = next("pipe2");
    *(void **)&libc.socketpair = next("socketpair");
    *(void **)&libc.create = next("pthread_create");
    *(void **)&libc.mask = next("pthread_sigmask"); /* the last: it tells that the others are there */
}

/* ---- memory ---- */

static bool no_memory(size_t bytes)
{
    if (bytes < least || !meets(MEMORY))
        return false;
    errno = ENOMEM;
    return true;
}

/* The program puts its own malloc() before glibc's and calls these. */
void *__libc_malloc(size_t bytes)
{
    static void *(*real)(size_t);
    if (!real)
        real = (void *(*)(size_t))next("__libc_malloc");
    return no_memory(bytes) ? NULL : real(bytes);
}
void *__libc_calloc(size_t count, size_t bytes)
{
    static void *(*real)(size_t, size_t);
    if (!real)
        real = (void *(*)(size_t, size_t))next("__libc_calloc");
    return no_memory(count * bytes) ? NULL : real(count, bytes);
}
void *__libc_realloc(void *old, size_t bytes)
{
    static void *(*real)(void *, size_t);
    if (!real)
        real = (void *(*)(void *, size_t))next("__libc_realloc");
    return (bytes > 0 || !old) && no_memory(bytes) ? NULL : real(old, bytes);
}
void *__libc_memalign(size_t alignment, size_t bytes)
{
    static void *(*real)(size_t, size_t);
    if (!real)
        real = (void *(*)(size_t, size_t))next("__libc_memalign");
    return no_memory(bytes) ? NULL : real(alignment, bytes);
}

/* ---- system calls ---- */

static int kind_of(long number)
{
    switch (number) {
    case SYS_read:
    case SYS_pread64:
    case SYS_readv: return READ;
    case SYS_write:
    case SYS_pwrite64:
    case SYS_writev: return WRITE;
    case SYS_open:
    case SYS_openat: return OPEN;
    case SYS_rename:
    case SYS_renameat:
    case SYS_renameat2:
    case SYS_link:
    case SYS_linkat: return RENAME;
    case SYS_fsync:
    case SYS_fdatasync: return SYNC;
    case SYS_mkdir:
    case SYS_mkdirat:
    case SYS_ftruncate:
    case SYS_fallocate: return MAKE;
    case SYS_stat:
    case SYS_fstat:
    case SYS_lstat:
    case SYS_newfstatat:
    case SYS_statx:
    case SYS_getdents64:
    case SYS_lseek: return LOOK;
    case SYS_close: return CLOSE;
    default: return -1;
    }
}

static long fail(long number, const greg_t *g)
{
    const long a = g[REG_RDI], b = g[REG_RSI], c = g[REG_RDX], d = g[REG_R10];
    if (number == SYS_close)
        raw(SYS_close, a, 0, 0, 0, 0, 0); /* as Linux does it: what fails to be closed is closed all the same */
    if (how > 0)
        return -how;
    if (number == SYS_readv || number == SYS_writev) {
        struct iovec one = {0};
        for (long i = 0; i < c && one.iov_len == 0; ++i)
            one = ((const struct iovec *)b)[i];
        one.iov_len = (one.iov_len + 1) / 2;
        return raw(number, a, (long)&one, 1, 0, 0, 0);
    }
    return raw(number, a, b, (c + 1) / 2, d, 0, 0);
}

static void on_call(int signal, siginfo_t *info, void *context)
{
    (void)signal;
    greg_t *g = ((ucontext_t *)context)->uc_mcontext.gregs;
    const long number = info->si_syscall;
    const int before = errno, kind = kind_of(number);
    const bool fails = kind >= 0 && meets((enum kind)kind);
    g[REG_RAX] = fails ? fail(number, g)
                       : raw(number, g[REG_RDI], g[REG_RSI], g[REG_RDX], g[REG_R10], g[REG_R8], g[REG_R9]);
    errno = before;
}

/* The part of glibc that holds code. */
static int find_code(struct dl_phdr_info *info, size_t size, void *user)
{
    uintptr_t *range = user;
    (void)size;
    const char *slash = strrchr(info->dlpi_name, '/');
    if (strcmp(slash ? slash + 1 : info->dlpi_name, "libc.so.6") != 0)
        return 0;
    for (int i = 0; i < info->dlpi_phnum; ++i)
        if (info->dlpi_phdr[i].p_type == PT_LOAD && info->dlpi_phdr[i].p_flags & PF_X) {
            range[0] = info->dlpi_addr + info->dlpi_phdr[i].p_vaddr;
            range[1] = range[0] + info->dlpi_phdr[i].p_memsz;
        }
    return 1;
}

static bool filter_calls(void)
{
    static const int met[] = {SYS_read,       SYS_pread64, SYS_readv,     SYS_write,    SYS_pwrite64,   SYS_writev,
                              SYS_open,       SYS_openat,  SYS_rename,    SYS_renameat, SYS_renameat2,  SYS_link,
                              SYS_linkat,     SYS_fsync,   SYS_fdatasync, SYS_mkdir,    SYS_mkdirat,    SYS_ftruncate,
                              SYS_fallocate,  SYS_stat,    SYS_fstat,     SYS_lstat,    SYS_newfstatat, SYS_statx,
                              SYS_getdents64, SYS_lseek,   SYS_close};
    enum { COUNT = sizeof met / sizeof *met };
    uintptr_t code[2] = {0, 0};
    struct sock_filter f[COUNT + 16];
    size_t n = 0;
    dl_iterate_phdr(find_code, code);
    if (code[0] == 0 || code[0] >> 32 != code[1] >> 32)
        return code[0] != 0; /* across a boundary of 4 GiB: one run in two thousand meets no system calls */
    const struct sock_filter allow = BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
    f[n++] = (struct sock_filter)BPF_STMT(BPF_LD | BPF_W | BPF_ABS,
                                          offsetof(struct seccomp_data, instruction_pointer) + 4);
    f[n++] = (struct sock_filter)BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, (uint32_t)(code[0] >> 32), 1, 0);
    f[n++] = allow;
    f[n++] = (struct sock_filter)BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, instruction_pointer));
    f[n++] = (struct sock_filter)BPF_JUMP(BPF_JMP | BPF_JGE | BPF_K, (uint32_t)code[0], 1, 0);
    f[n++] = allow;
    f[n++] = (struct sock_filter)BPF_JUMP(BPF_JMP | BPF_JGE | BPF_K, (uint32_t)code[1], 0, 1);
    f[n++] = allow;
    f[n++] = (struct sock_filter)BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, nr));
    for (size_t i = 0; i < COUNT; ++i)
        f[n++] = (struct sock_filter)BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, (uint32_t)met[i], (uint8_t)(COUNT - i), 0);
    f[n++] = allow;
    f[n++] = (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRAP);
    const struct sock_fprog program = {.len = (unsigned short)n, .filter = f};
    const struct sigaction action = {.sa_sigaction = on_call, .sa_flags = SA_SIGINFO | SA_NODEFER | SA_RESTART};
    return sigaction(SIGSYS, &action, NULL) == 0 && prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
           prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

/* Libraries block signals while they start threads (log4cplus, which OpenVDB loads): SIGSYS stays. */
int pthread_sigmask(int change, const sigset_t *set, sigset_t *before)
{
    sigset_t others;
    find_real();
    if (!set || change == SIG_UNBLOCK)
        return libc.mask(change, set, before);
    others = *set;
    sigdelset(&others, SIGSYS);
    return libc.mask(change, &others, before);
}

/* ---- starts of processes and threads ---- */

static bool no_start(void)
{
    if (!meets(START))
        return false;
    errno = how > 0 ? how : EAGAIN;
    return true;
}

pid_t fork(void)
{
    find_real();
    return no_start() ? -1 : libc.fork();
}
int execv(const char *path, char *const argv[])
{
    find_real();
    return no_start() ? -1 : libc.execv(path, argv);
}
int pipe2(int fds[2], int flags)
{
    find_real();
    return no_start() ? -1 : libc.pipe2(fds, flags);
}
int socketpair(int domain, int type, int protocol, int fds[2])
{
    find_real();
    return no_start() ? -1 : libc.socketpair(domain, type, protocol, fds);
}
int pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*routine)(void *), void *argument)
{
    find_real();
    return no_start() ? EAGAIN : libc.create(thread, attributes, routine, argument);
}

/* A child that posix_spawn() makes takes no signals, so its calls cannot be met: it is forked here instead. */
static struct {
    int fd, from, flags; /* from: copied from this descriptor; -1: opened */
    mode_t mode;
    const char *path;
} actions[8];
static int action_count;

int posix_spawn_file_actions_init(posix_spawn_file_actions_t *list)
{
    (void)list;
    action_count = 0;
    return 0;
}
int posix_spawn_file_actions_destroy(posix_spawn_file_actions_t *list)
{
    (void)list;
    return 0;
}
int posix_spawn_file_actions_addopen(posix_spawn_file_actions_t *list, int fd, const char *path, int flags, mode_t mode)
{
    (void)list;
    actions[action_count].fd = fd;
    actions[action_count].from = -1;
    actions[action_count].path = path;
    actions[action_count].flags = flags;
    actions[action_count++].mode = mode;
    return 0;
}
int posix_spawn_file_actions_adddup2(posix_spawn_file_actions_t *list, int from, int fd)
{
    (void)list;
    actions[action_count].fd = fd;
    actions[action_count++].from = from;
    return 0;
}
int posix_spawn(pid_t *pid, const char *path, const posix_spawn_file_actions_t *list,
                const posix_spawnattr_t *attributes, char *const argv[], char *const environment[])
{
    (void)list;
    (void)attributes;
    find_real();
    if (no_start())
        return errno;
    *pid = libc.fork();
    if (*pid != 0)
        return *pid < 0 ? errno : 0;
    armed = false;
    for (int i = 0; i < action_count; ++i) {
        const int from = actions[i].from >= 0 ? actions[i].from
                                              : open(actions[i].path, actions[i].flags, actions[i].mode);
        dup2(from, actions[i].fd);
        if (actions[i].from < 0 && from != actions[i].fd)
            close(from);
    }
    execve(path, argv, environment);
    _exit(127);
}

/* ---- main() ---- */

static int (*program_main)(int, char **, char **);

static int main_of_faults(int argc, char **argv, char **environment)
{
    armed = state != NULL;
    return program_main(argc, argv, environment);
}

static void choose(void)
{
    const char *path = getenv("FAULTS_STATE"), *at = getenv("FAULTS_AT"), *kind = getenv("FAULTS_KIND");
    const char *error = getenv("FAULTS_HOW"), *frames = getenv("FAULTS_DEPTH"), *bytes = getenv("FAULTS_LEAST");
    void *warm[2];
    find_real();
    const int fd = path ? open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0666) : -1;
    if (fd < 0 || ftruncate(fd, sizeof *state) != 0)
        return;
    void *memory = mmap(NULL, sizeof *state, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    close(fd);
    chosen = at ? strtoull(at, NULL, 10) : 0;
    least = bytes ? strtoull(bytes, NULL, 10) : 0;
    how = error ? atoi(error) : 0;
    depth = frames ? atoi(frames) : 0;
    for (int k = 0; kind && k < KINDS; ++k)
        if (strcmp(kind, kind_names[k]) == 0)
            chosen_kind = k;
    backtrace(warm, 2); /* it loads a library the first time */
    unsetenv("LD_PRELOAD");
    if (memory == MAP_FAILED || !filter_calls())
        return;
    state = memory;
}

int __libc_start_main(int (*main)(int, char **, char **), int argc, char **argv, void (*init)(void), void (*fini)(void),
                      void (*end)(void), void *stack_end)
{
    typedef int start(int (*)(int, char **, char **), int, char **, void (*)(void), void (*)(void), void (*)(void),
                      void *);
    start *real = (start *)next("__libc_start_main");
    program_main = main;
    choose();
    return real(main_of_faults, argc, argv, init, fini, end, stack_end);
}
