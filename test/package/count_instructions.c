/* Plugin of QEMU's user emulation: counts the instructions that a program executes, all its threads
 * together, and says so when it ends. What it needs of QEMU's interface is declared here, since Debian 12
 * has no header of it.
 *   gcc -shared -fPIC -o count.so count_instructions.c
 *   qemu-aarch64 -plugin ./count.so -d plugin PROGRAM
 */
#include <inttypes.h>
#include <stdatomic.h>
#include <stdio.h>

typedef uint64_t qemu_plugin_id_t;
struct qemu_plugin_tb;
typedef struct qemu_info_t qemu_info_t;
enum { no_registers = 0 };
void qemu_plugin_register_vcpu_tb_trans_cb(qemu_plugin_id_t id,
                                           void (*call)(qemu_plugin_id_t, struct qemu_plugin_tb*));
void qemu_plugin_register_vcpu_tb_exec_cb(struct qemu_plugin_tb* block,
                                          void (*call)(unsigned int, void*), int registers,
                                          void* data);
size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb* block);
void qemu_plugin_register_atexit_cb(qemu_plugin_id_t id, void (*call)(qemu_plugin_id_t, void*),
                                    void* data);
void qemu_plugin_outs(const char* text);

__attribute__((visibility("default"))) int qemu_plugin_version = 1;

/* One counter a thread, since adding to one in all threads takes most of the time. */
enum { kThreads = 1024 };
static struct {
  _Alignas(64) _Atomic uint64_t instructions;
} counters[kThreads];

static void executed(unsigned int thread, void* instructions) {
  atomic_fetch_add_explicit(&counters[thread % kThreads].instructions, (uintptr_t)instructions,
                            memory_order_relaxed);
}

static void translated(qemu_plugin_id_t id, struct qemu_plugin_tb* block) {
  (void)id;
  qemu_plugin_register_vcpu_tb_exec_cb(block, executed, no_registers,
                                       (void*)(uintptr_t)qemu_plugin_tb_n_insns(block));
}

static void ended(qemu_plugin_id_t id, void* data) {
  (void)id, (void)data;
  uint64_t sum = 0;
  for (int i = 0; i < kThreads; ++i) sum += counters[i].instructions;
  char text[64];
  snprintf(text, sizeof text, "instructions: %" PRIu64 "\n", sum);
  qemu_plugin_outs(text);
}

__attribute__((visibility("default"))) int qemu_plugin_install(qemu_plugin_id_t id,
                                                               const qemu_info_t* info, int argc,
                                                               char** argv) {
  (void)info, (void)argc, (void)argv;
  qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
  qemu_plugin_register_atexit_cb(id, ended, NULL);
  return 0;
}
