// Who the robot takes this browser for, and the exchange of a token for a cookie.

export type Session = { role: "operator" | "viewer" | "none"; token_needed: boolean };

/** Null: the robot cannot be reached. */
export async function session(): Promise<Session | null> {
  try {
    const answer = await fetch("/session", { cache: "no-store" });
    return answer.ok ? ((await answer.json()) as Session) : null;
  } catch {
    return null;
  }
}

/** Undefined when the robot took the token, else why not. */
export async function login(token: string): Promise<string | undefined> {
  try {
    const answer = await fetch("/login", {
      method: "POST",
      headers: { "Content-Type": "application/json" },
      body: JSON.stringify({ token }),
    });
    if (answer.ok) return undefined;
    return answer.status === 429 ? "Too many tries: wait a minute." : "The robot does not know this token.";
  } catch {
    return "The robot cannot be reached.";
  }
}

/** The token that came in the address, which does not stay there. */
export function tokenFromAddress(): string | null {
  const token = new URLSearchParams(location.hash.slice(1)).get("token");
  if (token !== null) history.replaceState(null, "", location.pathname + location.search);
  return token;
}
