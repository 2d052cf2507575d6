/* The contract between the plumbline program and a plugin: C11, and the only thing the two must agree on.
 *
 * A plugin is a shared library that exports one function, plumbline_plugin(), which returns a table of its nodes and
 * types. The host checks the ELF note below before it runs any code of the library, then the table: `abi_major` must be
 * equal, `abi_minor` may not exceed the host's. Every struct starts with its own size, which each side checks, so that
 * members can be added at the end. Strings are UTF-8, never null unless said, live as long as the library, and are never
 * freed by the other side. The table must be the same at every call.
 *
 * Most authors never see this header: plumbline/node.hpp is the C++ layer over it.
 */
#ifndef PLUMBLINE_PLUGIN_H
#define PLUMBLINE_PLUGIN_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define PLUMBLINE_MAGIC 0x424D4C50u /* "PLMB" */
#define PLUMBLINE_ABI_MAJOR 2
#define PLUMBLINE_ABI_MINOR 1

enum plumbline_cardinality {
  PLUMBLINE_ONE = 0,      /* exactly one item; an output of this kind is committed once */
  PLUMBLINE_OPTIONAL = 1, /* an input that need not be connected */
  PLUMBLINE_LIST = 2,     /* all items of the edge, in order */
  PLUMBLINE_EACH = 3      /* input only: the host runs the node once for each item, and joins the outputs in order */
};

enum plumbline_kind {
  PLUMBLINE_NUMBER = 0,
  PLUMBLINE_INTEGER = 1,
  PLUMBLINE_BOOLEAN = 2,
  PLUMBLINE_TEXT = 3,
  PLUMBLINE_FILE = 4,  /* path of a file; its content and base name go into the cache key */
  PLUMBLINE_FOLDER = 5 /* path of a folder; its path and the content of all files below go into the cache key */
};

/* What run() returns. Of any other number the host knows that the node failed, and no more. */
enum plumbline_answer {
  PLUMBLINE_DONE = 0,
  PLUMBLINE_FAILED = 1,
  PLUMBLINE_BAD_INPUT = 2,    /* what it was given cannot be used */
  PLUMBLINE_NOT_CONVERGED = 3 /* a solver ended without a result; the input may be sound */
};

enum plumbline_level { PLUMBLINE_DEBUG = 0, PLUMBLINE_INFO = 1, PLUMBLINE_WARNING = 2 };

typedef struct plumbline_bytes {
  const void* data;
  size_t size;
} plumbline_bytes;

typedef struct plumbline_port {
  uint32_t size;
  uint32_t cardinality;
  const char* name;
  const char* type;        /* "plumbline.Points/1", a plumbline_type.name */
  const char* fingerprint; /* of the type as this plugin was built: that of its plumbline_type */
  const char* frames;      /* "frame=?S" or "to=?T,from=?S" or "frame=building" or "" */
  const char* doc;
} plumbline_port;

typedef struct plumbline_param {
  uint32_t size;
  uint32_t kind;
  uint32_t is_list;         /* a list of values of `kind` */
  uint32_t choice_count;
  const char* name;
  const char* default_text; /* canonical text; NULL: the parameter must be given */
  const char* unit;         /* "" if it has none */
  const char* doc;
  double minimum, maximum;  /* -INFINITY and INFINITY where unbounded */
  const char* const* choices;
} plumbline_param;

/* What the host lends a node for one run. `context` is passed back as the first argument of every call. Thread-safe.
 * Functions that return int give 0 on success; on failure the host has recorded why and run() should return 1. */
typedef struct plumbline_host {
  uint32_t size;
  uint32_t abi_minor;
  void* context;
  void (*log)(void* context, int level, const char* text);
  void (*progress)(void* context, double fraction, const char* text);
  int (*cancelled)(void* context);                                        /* nonzero: return soon */
  uint64_t (*seed)(void* context);                                        /* the only source of randomness */
  void (*metric)(void* context, const char* name, double value, const char* unit); /* into the run record */
  void (*fail)(void* context, const char* message);                       /* the node's error; then return nonzero */
  const char* (*parameter)(void* context, const char* name);              /* canonical text; items of a list by '\x1f' */
  size_t (*item_count)(void* context, const char* port);                  /* 0: an optional input without connection */
  int (*get)(void* context, const char* port, size_t index, plumbline_bytes* out); /* valid until run() returns */
  int (*commit)(void* context, const char* port, const void* data, size_t size);   /* copies; a list port appends */
  const char* (*resolve)(void* context, const char* uri);                 /* uri of an artifact -> path of a file */
  int (*make_folder)(void* context, const char* port, const char** path, const char** uri); /* an empty folder to fill */
  const char* (*digest)(void* context, const char* path);                 /* SHA-256 of a file, hex; NULL if unreadable */
  int (*reserve_memory)(void* context, uint64_t bytes); /* waits until that much is free; given back after run() */
} plumbline_host;

typedef struct plumbline_node plumbline_node;

struct plumbline_node {
  uint32_t size;
  uint32_t version; /* of the algorithm: raise it when the same input gives another output */
  const char* kind; /* "register.rigid": family, dot, name */
  const char* role; /* "" for none; else the ports are those that schemas/roles/<role>.yaml declares */
  const char* summary;
  const plumbline_port* const* inputs;
  const plumbline_port* const* outputs;
  const plumbline_param* const* params;
  uint32_t input_count, output_count, param_count;
  uint32_t deterministic; /* 0: never reused from the store; else 1 */
  /* `node` is this entry, so that one function can serve many nodes: what tells them apart is in `user_data`. */
  int (*run)(const plumbline_host* host, const plumbline_node* node); /* gives a plumbline_answer */
  void* user_data; /* the plugin's own; the host never looks at it */
  /* Since ABI 2.1: what its role promises and this node does not give, as words with blanks between: "covariance".
   * NULL or "": nothing. */
  const char* lacks;
};

typedef struct plumbline_type {
  uint32_t size;
  uint32_t reserved;
  const char* name;        /* "plumbline.Points/1" */
  const char* fingerprint; /* 8 hex digits, schema_fingerprint() of schema_fingerprint.hpp */
  plumbline_bytes schema;  /* binary FlatBuffers schema (.bfbs) with comments and attributes */
} plumbline_type;

typedef struct plumbline_plugin_table {
  uint32_t magic, size, abi_major, abi_minor;
  const char *name, *version, *licence, *build_id;
  const plumbline_node* const* nodes;
  const plumbline_type* const* types;
  uint32_t node_count, type_count;
} plumbline_plugin_table;

/* The ELF note ".note.plumbline": read from the file, without running the library. owner "plumbline", type 1. */
typedef struct plumbline_note {
  uint32_t owner_size, text_size, type;
  char owner[12];
  uint32_t abi_major, abi_minor;
  char text[120]; /* name, version, licence, build id, each ended by NUL */
} plumbline_note;

#if defined(__GNUC__)
#define PLUMBLINE_EXPORT __attribute__((visibility("default")))
#else
#define PLUMBLINE_EXPORT
#endif

PLUMBLINE_EXPORT const plumbline_plugin_table* plumbline_plugin(void);

#ifdef __cplusplus
}
#endif
#endif
