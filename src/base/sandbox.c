/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "base/sandbox.h"

#include <errno.h>
#include <fcntl.h>
#include <glob.h>
#include <limits.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

extern char **environ;

/* ---- Landlock: numbers and structures of the kernel, since headers may be older than it ---- */

enum { LANDLOCK_CREATE = 444, LANDLOCK_ADD = 445, LANDLOCK_RESTRICT = 446 }; /* system calls */
enum { ASK_VERSION = 1, RULE_PATH_BENEATH = 1 };

#define WRITE_FILE (UINT64_C(1) << 1)
#define REMOVALS (UINT64_C(3) << 4)                             /* of folders and files */
#define MAKES (UINT64_C(0x7f) << 6)                             /* devices, folders, files, sockets, pipes, links */
#define RENAMES_BETWEEN (UINT64_C(1) << 13)                     /* from version 2 on */
#define TRUNCATES (UINT64_C(1) << 14)                           /* 3 */
#define DEVICE_CONTROLS (UINT64_C(1) << 15)                     /* 5 */
#define ABSTRACT_SOCKETS UINT64_C(1)                            /* 6: of processes outside */
#define SIGNALS UINT64_C(2)                                     /* 6: to processes outside */
#define OF_A_FILE (WRITE_FILE | TRUNCATES | DEVICE_CONTROLS)

typedef struct ruleset {
    uint64_t files, network, scopes;
} ruleset;

typedef struct __attribute__((packed)) path_rule {
    uint64_t allowed;
    int32_t folder;
} path_rule;

/* Returns Landlock's version; 0: the kernel has none, or it is switched off. */
static int landlock_version(void)
{
    const long version = syscall(LANDLOCK_CREATE, NULL, 0, ASK_VERSION);
    return version > 0 ? (int)version : 0;
}

/* Returns the rights to deny, limited to those that this Landlock version supports. */
static uint64_t handled(int version)
{
    return WRITE_FILE | REMOVALS | MAKES | (version >= 2 ? RENAMES_BETWEEN : 0) | (version >= 3 ? TRUNCATES : 0) |
           (version >= 5 ? DEVICE_CONTROLS : 0);
}

/* Allows rights in a path. False: it is missing, or no rule can be made. */
static bool allow(int rules, const char *path, uint64_t rights)
{
    struct stat st;
    const int fd = open(path, O_PATH | O_CLOEXEC);
    if (fd < 0)
        return false;
    const bool is_there = fstat(fd, &st) == 0;
    path_rule rule = {.allowed = is_there && S_ISDIR(st.st_mode) ? rights : rights & OF_A_FILE, .folder = fd};
    const bool is_allowed = is_there && syscall(LANDLOCK_ADD, rules, RULE_PATH_BENEATH, &rule, 0) == 0;
    close(fd);
    return is_allowed;
}

static void allow_in_home(int rules, const char *name, uint64_t rights)
{
    char path[PATH_MAX];
    const char *home = getenv("HOME");
    if (home && *home && snprintf(path, sizeof path, "%s/%s", home, name) < (int)sizeof path)
        allow(rules, path, rights);
}

/* Allows those devices and caches that this machine has. */
static void allow_devices(int rules, uint64_t rights)
{
    static const char *const devices[] = {"/dev/dri", "/dev/shm", "/dev/kfd", "/dev/udmabuf", "/var/tmp"};
    for (size_t i = 0; i < sizeof devices / sizeof *devices; ++i)
        allow(rules, devices[i], rights);
    glob_t found;
    if (glob("/dev/nvidia*", GLOB_NOSORT, NULL, &found) == 0) {
        for (size_t i = 0; i < found.gl_pathc; ++i)
            allow(rules, found.gl_pathv[i], rights);
        globfree(&found);
    }
    const char *cache = getenv("XDG_CACHE_HOME");
    if (cache && *cache)
        allow(rules, cache, rights);
    else
        allow_in_home(rules, ".cache", rights);
    allow_in_home(rules, ".nv", rights);
}

/* Makes the rules. Below 0 if the kernel has no Landlock, or gives no more rules. */
static int make_rules(const iso_sandbox_wish *wish, const char *folder, iso_status *status, iso_error *err)
{
    static const char *const streams[] = {"/dev/null", "/dev/zero", "/dev/full"};
    const int version = landlock_version();
    const uint64_t rights = handled(version);
    /* An X server's socket is abstract, and programs that draw on a device may speak to it. */
    const uint64_t scopes = SIGNALS | (wish->kind == ISO_SANDBOX_DEVICE ? 0 : ABSTRACT_SOCKETS);
    const ruleset refused = {.files = rights, .scopes = version >= 6 ? scopes : 0};
    const size_t size = version >= 6 ? sizeof refused : version >= 4 ? 2 * sizeof(uint64_t) : sizeof(uint64_t);
    const int rules = version > 0 ? (int)syscall(LANDLOCK_CREATE, &refused, size, 0) : -1;
    if (rules < 0)
        return rules;
    const char *missing = NULL;
    for (size_t i = 0; i < sizeof streams / sizeof *streams; ++i)
        if (!allow(rules, streams[i], rights) && errno != ENOENT)
            missing = streams[i];
    if (wish->kind == ISO_SANDBOX_DEVICE)
        allow_devices(rules, rights);
    if (folder && !allow(rules, folder, rights))
        missing = folder;
    else if (wish->output && !allow(rules, wish->output, rights))
        missing = wish->output;
    if (missing)
        *status = iso_fail(err, ISO_E_IO, "%s: no program can be allowed to write there: %s", missing, strerror(errno));
    return rules;
}

/* ---- seccomp ---- */

#ifdef __x86_64__
/* The numbers of system calls are those of this processor; programs of 32 bits have others. */
#define SKIP_UNLESS(what, value, count) BPF_JUMP(BPF_JMP | BPF_##what | BPF_K, value, 0, count)
#define LOAD(field) BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, field))
#define REFUSE(error) BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | (error))
#define LET BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW)
#define COUNT(list) (sizeof(list) / sizeof *(list))
enum { SOCKET_OF_32_BITS = 359, SOCKETPAIR_OF_32_BITS = 360, SOCKETCALL_OF_32_BITS = 102 };
enum { FIRST_OF_X32 = 0x40000000, IO_URING_SETUP = 425, KIND_OF_SOCKET = 15 };

static bool take_filter(const struct sock_filter *filter, size_t count)
{
    const struct sock_fprog program = {.len = (unsigned short)count, .filter = (struct sock_filter *)filter};
    return syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, 0, &program) == 0;
}

/* Refuses sockets. A pair of sockets is connected with each other, and stays allowed if it is a stream. A pair of
 * datagrams may send to any other socket of this machine that has a path. */
static bool refuse_sockets(bool but_of_this_machine)
{
    /* The bits of a pair's kind to test, and their required values: a program with such sockets may have such pairs. */
    const uint32_t looked_at = but_of_this_machine ? 0 : KIND_OF_SOCKET, wanted = looked_at & SOCK_STREAM;
    const struct sock_filter filter[] = {
        LOAD(arch),
        SKIP_UNLESS(JEQ, AUDIT_ARCH_X86_64, 15),
        LOAD(nr),
        SKIP_UNLESS(JGE, FIRST_OF_X32, 1),
        REFUSE(ENOSYS),
        SKIP_UNLESS(JEQ, IO_URING_SETUP, 1), /* makes sockets too */
        REFUSE(ENOSYS),
        SKIP_UNLESS(JEQ, SYS_socketpair, 4),
        LOAD(args[1]),
        BPF_STMT(BPF_ALU | BPF_AND | BPF_K, looked_at),
        SKIP_UNLESS(JEQ, wanted, 10),
        LET,
        SKIP_UNLESS(JEQ, SYS_socket, 3),
        LOAD(args[0]),
        SKIP_UNLESS(JEQ, but_of_this_machine ? AF_UNIX : UINT32_MAX, 6),
        LET,
        LET, /* any other call */
        LOAD(nr), /* of 32 bits */
        SKIP_UNLESS(JEQ, IO_URING_SETUP, 1), /* of the same number */
        REFUSE(ENOSYS),
        SKIP_UNLESS(JEQ, SOCKETCALL_OF_32_BITS, 1),
        REFUSE(EACCES),
        SKIP_UNLESS(JEQ, SOCKETPAIR_OF_32_BITS, 1),
        REFUSE(EACCES),
        SKIP_UNLESS(JEQ, SOCKET_OF_32_BITS, 1),
        REFUSE(EACCES),
        LET,
    };
    return take_filter(filter, COUNT(filter));
}

/* Calls that change a file's attributes, anywhere: its rights, owner, times and extended attributes. */
/* clang-format off */
static const uint16_t attribute_calls[] = {
    SYS_chmod, SYS_fchmod, SYS_fchmodat, 452 /* fchmodat2 */,
    SYS_chown, SYS_fchown, SYS_lchown, SYS_fchownat,
    SYS_utime, SYS_utimes, SYS_futimesat, SYS_utimensat,
    SYS_setxattr, SYS_lsetxattr, SYS_fsetxattr, 463 /* setxattrat */, 469 /* file_setattr */,
    SYS_removexattr, SYS_lremovexattr, SYS_fremovexattr, 466 /* removexattrat */,
};
static const uint16_t attribute_calls_of_32_bits[] = { /* in the same order; owners by 16 and by 32 bits */
    15, 94, 306, 452,
    182, 95, 16, 298, 212, 207, 198,
    30, 271, 299, 320, 412 /* utimensat_time64 */,
    226, 227, 228, 463, 469,
    235, 236, 237, 466,
};
/* clang-format on */

static size_t put_refusals(const uint16_t *calls, size_t count, struct sock_filter *filter)
{
    for (size_t i = 0; i < count; ++i) {
        filter[2 * i] = (struct sock_filter)SKIP_UNLESS(JEQ, calls[i], 1);
        filter[2 * i + 1] = (struct sock_filter)REFUSE(EACCES);
    }
    return 2 * count;
}

/* Refuses calls that change attributes, which Landlock does not check. */
static bool refuse_attributes(void)
{
    enum { HERE = COUNT(attribute_calls), OF_32_BITS = COUNT(attribute_calls_of_32_bits) };
    struct sock_filter filter[3 + 2 * HERE + 2 + 2 * OF_32_BITS + 1] = {
        LOAD(arch), SKIP_UNLESS(JEQ, AUDIT_ARCH_X86_64, 1 + 2 * HERE + 1), LOAD(nr)};
    size_t n = 3;
    n += put_refusals(attribute_calls, HERE, filter + n);
    filter[n++] = (struct sock_filter)LET;
    filter[n++] = (struct sock_filter)LOAD(nr);
    n += put_refusals(attribute_calls_of_32_bits, OF_32_BITS, filter + n);
    filter[n++] = (struct sock_filter)LET;
    return take_filter(filter, n);
}

static bool has_seccomp(void)
{
    const uint32_t action = SECCOMP_RET_ERRNO;
    return syscall(SYS_seccomp, SECCOMP_GET_ACTION_AVAIL, 0, &action) == 0;
}
#else
static bool refuse_sockets(bool but_of_this_machine)
{
    (void)but_of_this_machine;
    return true;
}

static bool refuse_attributes(void)
{
    return true;
}

static bool has_seccomp(void)
{
    return false;
}
#endif

/* ---- on and off ---- */

#define SWITCH "ISOSHADE_SANDBOX"

void iso_sandbox_set(bool on)
{
    setenv(SWITCH, on ? "on" : "off", 1);
}

bool iso_sandbox_is_on(void)
{
    const char *said = getenv(SWITCH);
    return !said || strcmp(said, "off") != 0;
}

void iso_sandbox_describe(char *text, size_t size)
{
    const int version = landlock_version();
    char writes[120] = "may write anywhere: this kernel has no Landlock";
    if (!iso_sandbox_is_on()) {
        snprintf(text, size, "off: other programs have all rights of yours");
        return;
    }
    if (version > 0)
        snprintf(writes, sizeof writes, "write into folders of their own alone (Landlock %d%s)", version,
                 version < 3 ? ", which lets them shorten others' files" : "");
    snprintf(text, size, "other programs %s, %s", writes,
             has_seccomp() ? "use no network (seccomp)" : "may use the network: seccomp is missing");
}

/* ---- before the fork ---- */

static const char *const folder_names[] = {"TMPDIR", "TMP", "TEMP", "HOME"}; /* the last only on request */
enum { FOLDER_NAMES = sizeof folder_names / sizeof *folder_names };

static void free_environment(char **environment, size_t copies)
{
    for (size_t i = 0; environment && i < copies; ++i)
        free(environment[i]);
    free(environment);
}

static bool is_named(const char *setting, const char *name)
{
    const size_t length = strlen(name);
    return strncmp(setting, name, length) == 0 && setting[length] == '=';
}

static bool is_kept(const char *setting, const iso_sandbox_wish *wish, size_t changed)
{
    bool kept = !(wish->first_in_path && is_named(setting, "PATH")) &&
                !(wish->without && strncmp(setting, wish->without, strlen(wish->without)) == 0);
    for (size_t k = 0; k < changed; ++k)
        kept = kept && !is_named(setting, folder_names[k]);
    return kept;
}

/* Makes the program's environment. Variables that name its folder, and a changed PATH, are copies and come first.
 * NULL: no memory. */
static char **make_environment(const iso_sandbox_wish *wish, const char *folder, size_t changed)
{
    const char *path = getenv("PATH");
    size_t count = 0, used = 0;
    while (environ[count])
        ++count;
    char **all = calloc(count + changed + 2, sizeof *all);
    for (; all && used < changed; ++used)
        if (asprintf(&all[used], "%s=%s", folder_names[used], folder) < 0) {
            all[used] = NULL;
            free_environment(all, changed);
            return NULL;
        }
    if (all && wish->first_in_path) {
        if (asprintf(&all[used], "PATH=%s:%s", wish->first_in_path, path ? path : "/usr/bin:/bin") < 0) {
            all[used] = NULL;
            free_environment(all, changed);
            return NULL;
        }
        ++used;
    }
    for (size_t i = 0; all && i < count; ++i)
        if (is_kept(environ[i], wish, changed))
            all[used++] = environ[i];
    return all;
}

/* Sets the program's environment. Without a folder of its own, names that point to folders stay. */
static iso_status set_environment(const iso_sandbox_wish *wish, const char *folder, iso_sandbox *box, iso_error *err)
{
    if (!folder && !wish->first_in_path && !wish->without)
        return ISO_OK;
    const size_t changed = folder ? (size_t)(FOLDER_NAMES - !wish->private_home) : 0;
    box->environment = make_environment(wish, folder, changed);
    NEED_MEMORY(box->environment, err, "no memory to start a program");
    box->copies = changed + (wish->first_in_path != NULL);
    return ISO_OK;
}

iso_status iso_sandbox_prepare(const iso_sandbox_wish *wish, const char *folder, iso_sandbox *box, iso_error *err)
{
    iso_status status = ISO_OK;
    *box = (iso_sandbox){.rules = -1, .closes = wish->kind != ISO_SANDBOX_NONE && iso_sandbox_is_on()};
    FREED char *whole = box->closes && folder ? realpath(folder, NULL) : NULL;
    if (box->closes && folder && !whole)
        return iso_fail(err, iso_errno_status(), "%s: cannot be a program's folder: %s", folder, strerror(errno));
    if (box->closes) {
        box->has_sockets = wish->kind == ISO_SANDBOX_DEVICE;
        box->rules = make_rules(wish, whole, &status, err);
    }
    TRY(status, set_environment(wish, whole, box, err));
    if (status != ISO_OK)
        iso_sandbox_release(box);
    return status;
}

void iso_sandbox_release(iso_sandbox *box)
{
    if (box->closes && box->rules >= 0)
        close(box->rules);
    free_environment(box->environment, box->copies);
    *box = (iso_sandbox){.rules = -1};
}

/* ---- after it ---- */

bool iso_sandbox_enter(const iso_sandbox *box)
{
    if (!box->closes)
        return true;
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0)
        return false;
    if (box->rules >= 0 && syscall(LANDLOCK_RESTRICT, box->rules, 0) != 0)
        return false;
    return !has_seccomp() || (refuse_sockets(box->has_sockets) && (box->has_sockets || refuse_attributes()));
}
