// SPDX-License-Identifier: Apache-2.0
// Commands to the program, each with what is known of its fate. None is ever sent twice.

export type Fate = "sent" | "done" | "refused" | "unknown"; ///< unknown: the link broke before the answer

export interface Command {
  id: number;
  do: string;
  label: string; ///< for people
  fate: Fate;
  error: string;
}

/// What is no JSON answers no command.
function parsed(text: string): { id?: number; ok?: boolean; error?: string } {
  try {
    return JSON.parse(text) as { id?: number; ok?: boolean; error?: string };
  } catch {
    return {};
  }
}

export class Commands {
  readonly log: Command[] = [];
  version = 0;
  private next = 1;

  constructor(
    private readonly send: (text: string) => boolean,
    private readonly onAnswer: (command: Command) => void,
  ) {}

  issue(label: string, what: { do: string } & Record<string, unknown>): Command {
    const command: Command = { id: this.next++, do: what.do, label, fate: "sent", error: "" };
    this.log.push(command);
    if (this.log.length > 200) this.log.shift();
    ++this.version;
    if (!this.send(JSON.stringify({ id: command.id, ...what }))) this.settle(command, "refused", "there is no connection; nothing was sent");
    return command;
  }

  answer(text: string): void {
    const reply = parsed(text);
    const command = this.log.find((one) => one.id === reply.id);
    if (command) this.settle(command, reply.ok ? "done" : "refused", reply.error ?? "");
  }

  linkLost(): void {
    for (const command of this.pending()) this.settle(command, "unknown", "the connection broke before the answer came; look whether it was done");
  }

  pending(): Command[] {
    return this.log.filter((one) => one.fate === "sent");
  }

  private settle(command: Command, fate: Fate, error: string): void {
    command.fate = fate;
    command.error = error;
    ++this.version;
    this.onAnswer(command);
  }
}
